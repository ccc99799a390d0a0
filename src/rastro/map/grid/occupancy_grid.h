// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/map/grid/tiled_cells.h"

namespace rastro {

/// A planar map of square cells with the occupancy probability of each, as in nav_msgs/OccupancyGrid and map_server.
/// Only the tiles with known cells take memory.
struct OccupancyGrid {
  static constexpr std::int8_t unknown = -1;

  double cell_m = 0.05;
  /// World position of the corner with the smallest x and y of cell (0, 0).
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  int width = 0, height = 0;
  TiledCells<std::int8_t> percent{unknown};  ///< 0..100 or `unknown`.

  std::int8_t at(int x, int y) const { return percent.at(x, y); }
  /// The cells (0, y) to (width - 1, y). Faster than at() for each of them.
  std::vector<std::int8_t> row(int y) const {
    std::vector<std::int8_t> cells(static_cast<std::size_t>(width));
    percent.copy_row(0, y, cells);
    return cells;
  }
  bool holds(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  Eigen::Vector2i cell_of(const Eigen::Vector2d& world) const {
    return ((world - origin) / cell_m).array().floor().cast<int>();
  }
  Eigen::Vector2d center_of(int x, int y) const { return origin + cell_m * Eigen::Vector2d(x + 0.5, y + 0.5); }
};

}  // namespace rastro
