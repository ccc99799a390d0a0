// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/map/octree/occupancy_octree.h"

namespace rastro {

/// The occupancy between two heights (z of the octree's world, meters), seen from above, in cells of the octree's
/// resolution: for each column the highest occupancy of its known cubes. Unknown where no cube is occupied and fewer
/// than a quarter of them are known. Error for a grid of more than 100 million cells.
OccupancyGrid slice_between(const OccupancyOctree& octree, double lowest_m, double highest_m);

}  // namespace rastro
