// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/map/octree/occupancy_octree.h"

namespace rastro {

/// What stands between two heights (z of the octree's world, metres), seen from above, in cells of the octree's
/// resolution: the likeliest occupied cube of each column, or how surely all its known cubes are free. Unknown where
/// fewer than a quarter of them are known. Error where it would be a picture larger than 100 million cells.
OccupancyGrid slice_between(const OccupancyOctree& octree, double lowest_m, double highest_m);

}  // namespace rastro
