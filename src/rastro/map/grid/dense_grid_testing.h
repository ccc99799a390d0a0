// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/map/grid/log_odds_grid.h"
#include "rastro/map/grid/occupancy_grid.h"

namespace rastro {

/// The occupancy grid from a LogOddsGrid, which holds every cell: what OccupancyMapper must make of the same scans.
inline OccupancyGrid to_occupancy(const ProbabilityView& view) {
  OccupancyGrid grid;
  grid.cell_m = view.cell_m;
  grid.origin = view.origin;
  grid.width = view.width;
  grid.height = view.height;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const int value = view.cells[static_cast<std::ptrdiff_t>(y) * view.width + x];
      if (value != LogOddsSteps::nothing_known)
        grid.percent.set(x, y, static_cast<std::int8_t>((100 * value + 127) / 255));
    }
  }
  return grid;
}

}  // namespace rastro
