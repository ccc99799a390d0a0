// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/grid_agreement.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rastro/evaluate/grid_alignment.h"
#include "rastro/evaluate/grid_cells.h"

namespace rastro {
namespace {

/// Cells with a cell of this kind within `reach` cells, along rows and then along columns.
CellMask near_mask(const OccupancyGrid& grid, const CellMask& mask, int reach) {
  const auto spread = [&](const CellMask& from, int dx, int dy) {
    CellMask to(from.size(), 0);
    for (int y = 0; y < grid.height; ++y)
      for (int x = 0; x < grid.width; ++x)
        for (int k = -reach; k <= reach && from[cell_index(grid, x, y)] != 0; ++k)
          if (grid.holds(x + k * dx, y + k * dy)) to[cell_index(grid, x + k * dx, y + k * dy)] = 1;
    return to;
  };
  return spread(spread(mask, 1, 0), 0, 1);
}

bool holds_at(const OccupancyGrid& grid, const CellMask& mask, const Eigen::Vector2d& world) {
  const Eigen::Vector2i cell = grid.cell_of(world);
  return grid.holds(cell.x(), cell.y()) && mask[cell_index(grid, cell.x(), cell.y())] != 0;
}

/// Occupied cells next to a free one: the inside of walls cannot be observed.
CellMask surface_of(const OccupancyGrid& grid) {
  CellMask surface = mask_of(grid, is_occupied);
  const CellMask beside_free = near_mask(grid, mask_of(grid, is_free), 1);
  for (std::size_t k = 0; k < surface.size(); ++k) surface[k] = surface[k] != 0 && beside_free[k] != 0 ? 1 : 0;
  return surface;
}

struct Share {
  std::int64_t hits = 0, all = 0;
  void count(bool hit) {
    ++all;
    hits += hit ? 1 : 0;
  }
  double value() const { return all > 0 ? static_cast<double>(hits) / static_cast<double>(all) : 0.0; }
};

class Comparison {
 public:
  Comparison(const OccupancyGrid& map, const OccupancyGrid& ground_truth, const GridAgreementOptions& options)
      : map_(map),
        ground_truth_(ground_truth),
        tolerance_m_(options.tolerance_cells * std::max(map.cell_m, ground_truth.cell_m)) {}

  GridAgreement measure(const SE2& ground_truth_from_map) const {
    GridAgreement result;
    result.ground_truth_from_map = ground_truth_from_map;
    compare_map_with_ground_truth(result);
    compare_ground_truth_with_map(result);
    const bool none = result.precision == 0.0 || result.recall_seen == 0.0;
    result.iou = none ? 0.0 : 1.0 / (1.0 / result.precision + 1.0 / result.recall_seen - 1.0);
    return result;
  }

 private:
  int reach_in(const OccupancyGrid& grid) const {
    return static_cast<int>(std::ceil(tolerance_m_ / grid.cell_m - 1e-9));
  }
  CellMask near(const OccupancyGrid& grid, bool (*is_it)(std::int8_t)) const {
    return near_mask(grid, mask_of(grid, is_it), reach_in(grid));
  }

  void compare_map_with_ground_truth(GridAgreement& result) const {
    const CellMask near_wall = near(ground_truth_, is_occupied), near_free = near(ground_truth_, is_free),
                   known = mask_of(ground_truth_, is_known);
    Share walls, free;
    for_each_cell(map_, [&](std::int8_t percent, const Eigen::Vector2d& center) {
      const Eigen::Vector2d in_ground_truth = result.ground_truth_from_map * center;
      if (is_occupied(percent)) walls.count(holds_at(ground_truth_, near_wall, in_ground_truth));
      if (is_free(percent) && holds_at(ground_truth_, known, in_ground_truth))
        free.count(holds_at(ground_truth_, near_free, in_ground_truth));
    });
    result.map_occupied = walls.all;
    result.precision = walls.value();
    result.free_agreement = free.value();
  }

  void compare_ground_truth_with_map(GridAgreement& result) const {
    const CellMask near_wall = near(map_, is_occupied), near_known = near(map_, is_known),
                   free = mask_of(map_, is_free);
    const CellMask surface = surface_of(ground_truth_);
    const SE2 map_from_ground_truth = result.ground_truth_from_map.inverse();
    Share walls, seen, explored;
    std::size_t cell = 0;
    for_each_cell(ground_truth_, [&](std::int8_t percent, const Eigen::Vector2d& center) {
      const Eigen::Vector2d in_map = map_from_ground_truth * center;
      if (surface[cell++] != 0) {
        const bool hit = holds_at(map_, near_wall, in_map);
        walls.count(hit);
        if (holds_at(map_, near_known, in_map)) seen.count(hit);
      }
      if (is_free(percent)) explored.count(holds_at(map_, free, in_map));
    });
    result.ground_truth_occupied = walls.all;
    result.ground_truth_seen = seen.all;
    result.recall = walls.value();
    result.recall_seen = seen.value();
    result.explored = explored.value();
  }

  const OccupancyGrid& map_;
  const OccupancyGrid& ground_truth_;
  const double tolerance_m_;
};

}  // namespace

GridAgreement grid_agreement(const OccupancyGrid& map, const OccupancyGrid& ground_truth,
                             const GridAgreementOptions& options, const SE2& ground_truth_from_map) {
  const SE2 alignment = options.align ? align_grids(map, ground_truth, ground_truth_from_map, options.search_m,
                                                    options.search_deg * std::numbers::pi / 180.0)
                                      : ground_truth_from_map;
  return Comparison(map, ground_truth, options).measure(alignment);
}

}  // namespace rastro
