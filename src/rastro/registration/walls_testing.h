// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "rastro/math/se2.h"

namespace rastro::testing {

/// Straight walls in the plane, meters, and a laser's ranges to them in closed form.
class Walls {
 public:
  void add(const Eigen::Vector2d& from, const Eigen::Vector2d& to) { walls_.emplace_back(from, to); }
  void add_polygon(const std::vector<Eigen::Vector2d>& corners) {
    for (std::size_t k = 0; k < corners.size(); ++k) add(corners[k], corners[(k + 1) % corners.size()]);
  }
  void add_box(double left, double bottom, double right, double top) {
    add_polygon({{left, bottom}, {right, bottom}, {right, top}, {left, top}});
  }

  /// Length of a ray up to the first wall; infinite without one. `direction` is a unit vector.
  double range(const Eigen::Vector2d& from, const Eigen::Vector2d& direction) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [start, end] : walls_) {
      const Eigen::Vector2d along = end - start, to_wall = start - from;
      const double slope = cross(direction, along);
      if (std::abs(slope) < 1e-12) continue;
      const double distance = cross(to_wall, along) / slope, share = cross(to_wall, direction) / slope;
      if (distance > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, distance);
    }
    return nearest;
  }

  /// Endpoints of beams in all directions, in the body frame; the laser is the body. Those beyond `reach_m` are left
  /// out.
  std::vector<Eigen::Vector2d> returns(const SE2& world_from_body, int beams, double reach_m) const {
    std::vector<Eigen::Vector2d> points;
    for (int k = 0; k < beams; ++k) {
      const double angle = 2.0 * M_PI * k / beams;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      const double distance = range(world_from_body.translation(), world_from_body.rotation() * direction);
      if (distance < reach_m) points.emplace_back(distance * direction);
    }
    return points;
  }

 private:
  static double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> walls_;
};

}  // namespace rastro::testing
