// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// t' of p_in_current = R' p_in_first + t', from two points in the first camera's frame and their observations in the
/// current one (normalized, (u - cx) / f), METHODS 2.3. With D = B' - A' and rows r1, r2, r3 of R',
///   A_z = (r1 - b_x r3).D / (b_x - a_x)  or  (r2 - b_y r3).D / (b_y - a_y), whichever has the larger divisor,
///   t' = A_z (a_x, a_y, 1) - R' A'.
/// nullopt where a and b coincide or a point would be behind the camera.
std::optional<Eigen::Vector3d> translation_from_two_points(const Eigen::Matrix3d& rotation,
                                                           const Eigen::Vector3d& point_a,
                                                           const Eigen::Vector3d& point_b, const Eigen::Vector2d& a,
                                                           const Eigen::Vector2d& b);

struct TranslationFit {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  std::vector<std::uint8_t> is_inlier;  ///< One per point.
  int inliers = 0;
  int iterations = 0;  ///< Samples drawn.
};

/// t' by RANSAC over pairs of points, then refined on the inliers by Gauss-Newton on their reprojection errors; R' is
/// fixed. `initial`, where given, is tried first. nullopt for fewer than two points or inliers. The same seed gives the
/// same bits.
std::optional<TranslationFit> estimate_translation(const Eigen::Matrix3d& rotation,
                                                   std::span<const Eigen::Vector3d> points_in_first,
                                                   std::span<const Eigen::Vector2d> points,
                                                   const CalibratedRansacOptions& options,
                                                   const std::optional<Eigen::Vector3d>& initial = std::nullopt);

/// Direction of t (length 1) of p_in_second = R p_in_first + t for a known R. Every pair of normalized points gives
/// t.(b x R a) = 0, so two pairs give t. RANSAC over two pairs, least squares over the inliers; of +t and -t the one
/// with more points in front of both cameras. nullopt for fewer than two pairs or for a pure rotation.
std::optional<TranslationFit> estimate_direction(const Eigen::Matrix3d& rotation, std::span<const Eigen::Vector2d> a,
                                                 std::span<const Eigen::Vector2d> b,
                                                 const CalibratedRansacOptions& options);

}  // namespace rastro
