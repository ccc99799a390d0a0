// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// Homography b ~ H a from four pairs, in closed form by way of the projective basis; nullopt if three points lie on a
/// line.
std::optional<Eigen::Matrix3d> homography_from_four(const PointPairs& pairs, const std::uint32_t* indices);

/// H with b ~ H a by RANSAC; errors are distances in image b. nullopt for fewer than four pairs or if every sample is
/// degenerate. Hartley and Zisserman 2004, algorithm 4.6.
std::optional<RobustFit> estimate_homography(const PointPairs& pairs, const RansacOptions& options);

/// One Gauss-Newton step from `start` on the pairs with an error below `max_error_px` in image b; the returned errors
/// and inliers are those after the step. nullopt with too few such pairs.
std::optional<RobustFit> refine_homography(const PointPairs& pairs, const Eigen::Matrix3d& start, double max_error_px);

/// The mapped `point`; nullopt at or beyond infinity.
std::optional<Eigen::Vector2d> transfer(const Eigen::Matrix3d& homography, const Eigen::Vector2d& point);

}  // namespace rastro
