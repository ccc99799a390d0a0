// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace rastro {

/// Keeps points at least a distance apart, in constant time a point.
class DistanceGrid {
 public:
  /// Points have 0 <= x < width, 0 <= y < height. A distance of 0 keeps all.
  DistanceGrid(int width, int height, double distance)
      : squared_(static_cast<float>(distance * distance)),
        cell_(static_cast<float>(std::max(distance, 1.0))),
        columns_(static_cast<int>(static_cast<float>(width) / cell_) + 1),
        rows_(static_cast<int>(static_cast<float>(height) / cell_) + 1),
        cells_(static_cast<std::size_t>(columns_ * rows_)) {}

  /// Adds the point unless one nearer than the distance is there; says whether it did.
  bool add_if_far(float x, float y) {
    const int column = std::clamp(static_cast<int>(x / cell_), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(y / cell_), 0, rows_ - 1);
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) {
        for (const Point& point : cell(c, r)) {
          const float dx = point.x - x, dy = point.y - y;
          if (dx * dx + dy * dy < squared_) return false;
        }
      }
    }
    cell(column, row).push_back({x, y});
    return true;
  }

 private:
  struct Point {
    float x, y;
  };
  std::vector<Point>& cell(int column, int row) { return cells_[static_cast<std::size_t>(row * columns_ + column)]; }

  float squared_;
  float cell_;
  int columns_;
  int rows_;
  std::vector<std::vector<Point>> cells_;
};

}  // namespace rastro
