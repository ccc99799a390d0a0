// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/math/se2.h"

namespace rastro {

/// Agreement of two occupancy maps. Cells of 65 % and more are occupied, cells under 20 % free, the others unknown.
/// "Near" is within the tolerance, in either direction of the axes. Shares are 0 to 1, and 0 with nothing to count.
struct GridAgreement {
  SE2 ground_truth_from_map;      ///< As given, or as estimated.
  std::int64_t map_occupied = 0;  ///< Occupied cells of the map.
  /// Occupied cells of the ground truth next to a free one: the visible part of walls.
  std::int64_t ground_truth_occupied = 0;
  std::int64_t ground_truth_seen = 0;  ///< Of these, those near a known cell of the map.
  double precision = 0.0;              ///< Share of the map's occupied cells near an occupied cell of the ground truth.
  double recall = 0.0;                 ///< Share of ground_truth_occupied near an occupied cell of the map.
  double recall_seen = 0.0;            ///< The same for ground_truth_seen.
  double iou = 0.0;                    ///< IoU of occupied cells, from precision and recall_seen: 1 / (1/p + 1/r - 1).
  /// Share of the map's free cells with known ground truth that are near a true free one.
  double free_agreement = 0.0;
  double explored = 0.0;  ///< Share of the true free cells that are free in the map.
};

struct GridAgreementOptions {
  double tolerance_cells = 1.0;  ///< In cells of the coarser map.
  /// Searches around ground_truth_from_map for the pose that aligns the map's walls best with the true ones.
  bool align = false;
  double search_m = 1.0, search_deg = 5.0;  ///< Search range.
};

/// `ground_truth_from_map`: pose of the map's frame in that of the ground truth.
GridAgreement grid_agreement(const OccupancyGrid& map, const OccupancyGrid& ground_truth,
                             const GridAgreementOptions& options, const SE2& ground_truth_from_map = {});

}  // namespace rastro
