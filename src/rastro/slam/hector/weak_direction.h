// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "rastro/math/se2.h"
#include "rastro/slam/hector/submap.h"

namespace rastro {

/// The direction parallel to most surfaces, body frame, and the share of surfaces across it.
struct WeakDirection {
  Eigen::Vector2d direction;
  double share;
};

/// Determined from the scan alone, because the cells of a map are never as smooth as a wall. `points` in the order of
/// the beams, body frame.
WeakDirection weak_direction(std::span<const Eigen::Vector2d> points);

/// Points that the map confirms at that pose. A person who walks by, or what comes into view, is no structure that the
/// map could constrain the motion by. Of a few scans, nothing tells which is which: all points.
std::vector<Eigen::Vector2d> structure_of(const Submap& map, std::span<const Eigen::Vector2d> points,
                                          const SE2& submap_from_body);

}  // namespace rastro
