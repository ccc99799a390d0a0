// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/multiview/point_pairs.h"

namespace rastro {

/// Up to three fundamental matrices b' F a = 0 from seven pairs. Hartley and Zisserman 2004, section 11.1.2.
std::vector<Eigen::Matrix3d> fundamental_from_seven(const PointPairs& pairs, const std::uint32_t* indices);

/// F by RANSAC; errors are Sampson distances (first-order distance to the epipolar constraint, section 11.4.3), in
/// pixels squared.
std::optional<RobustFit> estimate_fundamental(const PointPairs& pairs, const RansacOptions& options);

/// Squared Sampson distance of one pair.
double sampson_distance_squared(const Eigen::Matrix3d& fundamental, const Eigen::Vector2d& a, const Eigen::Vector2d& b);

}  // namespace rastro
