// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/slice.h"

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr double most_cells = 1e8;
constexpr int least_known_of_four = 1;

std::int8_t column_percent(const OccupancyOctree& octree, const Eigen::Vector2d& position, double lowest, int cubes) {
  int known = 0;
  double likeliest = 0.0;
  for (int k = 0; k < cubes; ++k) {
    const double height = lowest + (k + 0.5) * octree.resolution_m();
    const auto occupancy = octree.occupancy_at({position.x(), position.y(), height});
    if (!occupancy) continue;
    ++known;
    likeliest = std::max(likeliest, *occupancy);
  }
  const bool enough = 4 * known >= least_known_of_four * cubes && known > 0;
  if (!enough && likeliest < 0.5) return OccupancyGrid::unknown;
  return static_cast<std::int8_t>(std::clamp(std::lround(100.0 * likeliest), 0L, 100L));
}

}  // namespace

OccupancyGrid slice_between(const OccupancyOctree& octree, double lowest_m, double highest_m) {
  RASTRO_CHECK(lowest_m < highest_m, "a slice has a thickness");
  OccupancyGrid grid;
  grid.cell_m = octree.resolution_m();
  const Eigen::Vector2d low = (octree.low().head<2>() / grid.cell_m).array().round();
  const Eigen::Vector2d size = (octree.high().head<2>() / grid.cell_m).array().round() - low.array();
  if (!(size.x() * size.y() <= most_cells))
    throw Error("the map is too large for an image of these cells", "--resolution", "give larger ones");
  grid.origin = low * grid.cell_m;
  grid.width = static_cast<int>(size.x());
  grid.height = static_cast<int>(size.y());
  // Whole cubes, from the first to the last that overlaps the band.
  const double bottom = std::floor(std::max(lowest_m, octree.low().z()) / grid.cell_m + 1e-9) * grid.cell_m;
  const double top = std::min(highest_m, octree.high().z());
  const int cubes = std::max(0, static_cast<int>(std::ceil((top - bottom) / grid.cell_m - 1e-9)));
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::int8_t percent = column_percent(octree, grid.center_of(x, y), bottom, cubes);
      if (percent != OccupancyGrid::unknown) grid.percent.set(x, y, percent);
    }
  }
  return grid;
}

}  // namespace rastro
