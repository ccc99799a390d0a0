// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdlib>
#include <span>
#include <utility>
#include <vector>

namespace rastro {

/// The cells of a scan's sensor and returns; cell (0, 0) has its corner in the origin. Returns farther than 32,768
/// cells from the sensor are left out.
struct ScanCells {
  ScanCells(double cell_m, const Eigen::Vector2d& sensor_position, std::span<const Eigen::Vector2d> return_positions);

  Eigen::Vector2i sensor;
  std::vector<Eigen::Vector2i> returns;
  Eigen::Vector2i least, most;  ///< Of all these cells.
};

/// The rectangle of cells that a grid covers.
struct CellBox {
  Eigen::Vector2i first = Eigen::Vector2i::Zero();
  Eigen::Vector2i size = Eigen::Vector2i::Zero();

  bool holds(const ScanCells& scan) const;
  /// Itself if it holds the scan; else larger than required, or a slow drive would grow it with every scan.
  CellBox grown_to_hold(const ScanCells& scan) const;
};

/// Calls visit(cell) for the cells of a beam, by Bresenham's line, without the last. `offset` leads from the first to
/// the last cell; a Position is whatever stands for a cell, with what leads from it to the next in x and in y.
template <typename Position, typename Visit>
void walk_beam(const Eigen::Vector2i& offset, Position cell, const Position& next_in_x, const Position& next_in_y,
               const Visit& visit) {
  int length = std::abs(offset.x()), width = std::abs(offset.y());
  Position along = offset.x() >= 0 ? next_in_x : Position(-next_in_x);
  Position across = offset.y() >= 0 ? next_in_y : Position(-next_in_y);
  if (width > length) {
    std::swap(along, across);
    std::swap(length, width);
  }
  int error = length / 2;
  for (int i = 0; i < length; ++i) {
    visit(cell);
    error -= width;
    if (error < 0) {
      error += length;
      cell += across;
    }
    cell += along;
  }
}

}  // namespace rastro
