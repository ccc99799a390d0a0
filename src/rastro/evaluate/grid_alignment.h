// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/math/se2.h"

namespace rastro {

/// Where the map's frame lies in the truth's, at most `search_m` along either axis and `search_rad` from `start` (the
/// turn is about the middle of the map): the place that brings the occupied cells of the map nearest to occupied ones
/// of the truth, by a search over a lattice that is then refined. `start` where one of the maps has no occupied cell.
SE2 align_grids(const OccupancyGrid& map, const OccupancyGrid& truth, const SE2& start, double search_m,
                double search_rad);

}  // namespace rastro
