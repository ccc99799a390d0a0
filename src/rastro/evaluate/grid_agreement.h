// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/math/se2.h"

namespace rastro {

/// How two occupancy maps agree. Cells of 65 % and more are occupied, cells under 20 % free, the others unknown. "Near"
/// is within the tolerance, in either direction of the axes. Shares are 0 to 1, and 0 where there is nothing to count.
struct GridAgreement {
  SE2 truth_from_map;             ///< As given, or as found.
  std::int64_t map_occupied = 0;  ///< Occupied cells of the map.
  std::int64_t truth_occupied =
      0;                        ///< Occupied cells of the truth that border on a free one: what can be seen of walls.
  std::int64_t truth_seen = 0;  ///< Of these, those near a cell that the map knows.
  double precision = 0.0;       ///< Of the map's occupied cells: near an occupied cell of the truth.
  double recall = 0.0;          ///< Of truth_occupied: near an occupied cell of the map.
  double recall_seen = 0.0;     ///< The same of truth_seen.
  double iou = 0.0;             ///< Of occupied cells, from precision and recall_seen: 1 / (1/p + 1/r - 1).
  double free_agreement = 0.0;  ///< Of the map's free cells where the truth is known: near a free one.
  double explored = 0.0;        ///< Of the truth's free cells: free in the map.
};

struct GridAgreementOptions {
  double tolerance_cells = 1.0;  ///< Of the coarser of both.
  /// Looks around truth_from_map for the place and turn that bring the map's walls nearest to the true ones.
  bool align = false;
  double search_m = 1.0, search_deg = 5.0;  ///< How far.
};

/// `truth_from_map`: where the map's frame lies in the truth's.
GridAgreement grid_agreement(const OccupancyGrid& map, const OccupancyGrid& truth, const GridAgreementOptions& options,
                             const SE2& truth_from_map = {});

}  // namespace rastro
