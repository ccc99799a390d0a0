// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/math/se2.h"

namespace rastro {

/// Pose of the map's frame in that of the ground truth, at most `search_m` along either axis and `search_rad` from
/// `start` (the rotation is about the center of the map): the pose that aligns the occupied cells of the map best with
/// occupied ones of the ground truth, by a search over a lattice that is then refined. `start` if one of the maps has
/// no occupied cell.
SE2 align_grids(const OccupancyGrid& map, const OccupancyGrid& ground_truth, const SE2& start, double search_m,
                double search_rad);

}  // namespace rastro
