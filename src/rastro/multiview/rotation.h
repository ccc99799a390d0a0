// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/math/so3.h"
#include "rastro/multiview/point_pairs.h"

namespace rastro {

struct RotationFit {
  SO3 second_from_first;
  std::vector<std::uint8_t> is_inlier;  ///< One per pair.
  int inliers = 0;
  int iterations = 0;
  double median_error_px = 0.0;  ///< Of all pairs, outliers too, in image b.
};

/// The rotation that best maps the directions of the first view to those of the second (both normalized): RANSAC over
/// two pairs, least squares over the inliers. Matches it explains need no translation: with as many inliers as an
/// essential matrix, the camera only rotated, or was at rest. nullopt for fewer than two pairs or without inliers.
std::optional<RotationFit> rotation_between(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                            const CalibratedRansacOptions& options);

}  // namespace rastro
