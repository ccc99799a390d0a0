// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// Homography b ~ H a from four pairs, in closed form by way of the projective basis; nullopt when three points lie on
/// a line.
std::optional<Eigen::Matrix3d> homography_from_four(const PointPairs& pairs, const std::uint32_t* indices);

/// H with b ~ H a by RANSAC; errors are distances in image b. nullopt for fewer than four pairs or when every sample
/// degenerates. Hartley and Zisserman 2004, algorithm 4.6.
std::optional<RobustFit> estimate_homography(const PointPairs& pairs, const RansacOptions& options);

/// One Gauss-Newton step from `start` on the pairs it brings within `max_error_px` of each other in image b; the errors
/// and inliers returned are those after it. nullopt when too few pairs are.
std::optional<RobustFit> refine_homography(const PointPairs& pairs, const Eigen::Matrix3d& start, double max_error_px);

/// Where `point` goes; nullopt at or behind infinity.
std::optional<Eigen::Vector2d> transfer(const Eigen::Matrix3d& homography, const Eigen::Vector2d& point);

}  // namespace rastro
