// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>

#include "rastro/base/task_pool.h"
#include "rastro/image/image.h"
#include "rastro/synthetic/laser_world.h"

namespace rastro {

enum class PlanCell : std::uint8_t { unknown, free, occupied };

/// A plan at the laser's height, in square cells. Cell (column, row) covers low + resolution * [column, column + 1) x
/// [row, row + 1): rows go up with y.
struct FloorPlan {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  ///< In the world, meters.
  double resolution = 0.05;                       ///< Meters.
  Image<PlanCell> cells;

  /// unknown outside the plan.
  PlanCell at(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d cell = (point - low) / resolution;
    if (!(cell.x() >= 0.0 && cell.y() >= 0.0 && cell.x() < cells.width() && cell.y() < cells.height()))
      return PlanCell::unknown;
    return cells.at(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
  }
};

/// The true plan of static objects, as far as the first `scans` scans can see through open doors and glass: the best
/// possible map of them. occupied: the outermost millimeter of a solid or a pane runs through the cell; free: a beam
/// crosses it and it has no object; unknown: no beam ever reaches it. The same for any pool.
FloorPlan true_floor_plan(const LaserWorld& world, std::int64_t scans, double resolution, TaskPool& pool);

/// Writes floor_plan.pgm and floor_plan.yaml for map_server: 0 occupied, 254 free, 205 unknown. Throws Error if they
/// cannot be written.
void write_floor_plan(const FloorPlan& plan, const std::filesystem::path& folder);

/// Calls visit(column, row) for every cell that a line touches, in order; positions in units of cells (Amanatides and
/// Woo 1987).
template <typename Visit>
void visit_cells(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Visit&& visit) {
  const Eigen::Vector2d ray = to - from;
  int cell[2], step[2];
  double next[2], gap[2];
  int left = 0;
  for (int axis = 0; axis < 2; ++axis) {
    cell[axis] = static_cast<int>(std::floor(from[axis]));
    left += std::abs(static_cast<int>(std::floor(to[axis])) - cell[axis]);
    step[axis] = ray[axis] > 0.0 ? 1 : -1;
    gap[axis] = ray[axis] == 0.0 ? std::numeric_limits<double>::infinity() : 1.0 / std::abs(ray[axis]);
    const double border = ray[axis] > 0.0 ? cell[axis] + 1.0 - from[axis] : from[axis] - cell[axis];
    next[axis] = ray[axis] == 0.0 ? gap[axis] : border * gap[axis];
  }
  visit(cell[0], cell[1]);
  for (; left > 0; --left) {
    const int axis = next[0] < next[1] ? 0 : 1;
    cell[axis] += step[axis];
    next[axis] += gap[axis];
    visit(cell[0], cell[1]);
  }
}

}  // namespace rastro
