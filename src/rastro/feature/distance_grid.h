// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace rastro {

/// Keeps points at least a distance apart, in constant time per point.
class DistanceGrid {
 public:
  /// Points have 0 <= x < width, 0 <= y < height. A distance of 0 keeps all.
  DistanceGrid(int width, int height, double distance)
      : squared_(static_cast<float>(distance * distance)),
        cell_(static_cast<float>(std::max(distance, 1.0))),
        columns_(static_cast<int>(static_cast<float>(width) / cell_) + 1),
        rows_(static_cast<int>(static_cast<float>(height) / cell_) + 1),
        first_(static_cast<std::size_t>(columns_ * rows_), none) {}

  /// Adds the point unless a point closer than the distance is present; returns whether it was added.
  bool add_if_far(float x, float y) {
    if (!is_far(x, y)) return false;
    add(x, y);
    return true;
  }
  /// Whether no point is closer than the distance.
  bool is_far(float x, float y) const {
    const int row = row_of(y), column = column_of(x);
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
      for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) {
        for (std::int32_t i = first_[index_of(r, c)]; i != none; i = at(i).next) {
          const float dx = at(i).x - x, dy = at(i).y - y;
          if (dx * dx + dy * dy < squared_) return false;
        }
      }
    }
    return true;
  }
  /// Adds the point unconditionally.
  void add(float x, float y) {
    std::int32_t& first = first_[index_of(row_of(y), column_of(x))];
    points_.push_back({x, y, first});
    first = static_cast<std::int32_t>(points_.size()) - 1;
  }

 private:
  static constexpr std::int32_t none = -1;
  /// Points of one cell form a linked list, so that an empty grid costs one pass over plain numbers.
  struct Point {
    float x, y;
    std::int32_t next;
  };
  const Point& at(std::int32_t index) const { return points_[static_cast<std::size_t>(index)]; }
  std::size_t index_of(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  int column_of(float x) const { return std::clamp(static_cast<int>(x / cell_), 0, columns_ - 1); }
  int row_of(float y) const { return std::clamp(static_cast<int>(y / cell_), 0, rows_ - 1); }

  float squared_;
  float cell_;
  int columns_;
  int rows_;
  std::vector<std::int32_t> first_;  ///< Of each cell.
  std::vector<Point> points_;
};

}  // namespace rastro
