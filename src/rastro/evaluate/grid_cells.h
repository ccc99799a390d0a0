// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rastro/map/grid/occupancy_grid.h"

namespace rastro {

inline bool is_occupied(std::int8_t percent) { return percent >= 65; }
inline bool is_free(std::int8_t percent) { return percent >= 0 && percent < 20; }
inline bool is_known(std::int8_t percent) { return is_occupied(percent) || is_free(percent); }

using CellMask = std::vector<std::uint8_t>;  ///< 0 or 1 per cell, row by row.

inline std::size_t cell_index(const OccupancyGrid& grid, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x);
}

inline CellMask mask_of(const OccupancyGrid& grid, bool (*is_it)(std::int8_t)) {
  CellMask mask;
  mask.reserve(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  for (int y = 0; y < grid.height; ++y)
    for (const std::int8_t percent : grid.row(y)) mask.push_back(is_it(percent) ? 1 : 0);
  return mask;
}

/// Calls visit(percent, center), row by row.
template <typename Visit>
void for_each_cell(const OccupancyGrid& grid, const Visit& visit) {
  for (int y = 0; y < grid.height; ++y) {
    int x = 0;
    for (const std::int8_t percent : grid.row(y)) visit(percent, grid.center_of(x++, y));
  }
}

}  // namespace rastro
