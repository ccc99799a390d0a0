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
  std::vector<std::uint8_t> is_inlier;  ///< One a pair.
  int inliers = 0;
  int iterations = 0;
  double median_error_px = 0.0;  ///< Of all pairs, outliers too, in image b.
};

/// The rotation alone that brings the points of the first view nearest to those of the second (both normalised): RANSAC
/// over two pairs, least squares over the inliers. What it explains needs no translation: as many inliers as an
/// essential matrix has mean that the camera only turned, or stood still. nullopt for fewer than two pairs or when
/// nothing agrees.
std::optional<RotationFit> rotation_between(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                            const CalibratedRansacOptions& options);

}  // namespace rastro
