// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/grid_alignment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rastro/evaluate/grid_cells.h"

namespace rastro {
namespace {

constexpr double reach_m = 0.5;  ///< Farther walls do not count.
constexpr double first_step_m = 0.2, first_step_rad = 0.5 * std::numbers::pi / 180.0;
constexpr int refinements = 7;
constexpr std::size_t most_points = 4000;

/// Distance of every cell to the nearest occupied one, meters, by two sweeps over neighbors (Borgefors 1986): up to 8
/// % too long, which does not affect the choice between neighboring poses.
std::vector<float> distances(const OccupancyGrid& grid) {
  const auto step = static_cast<float>(grid.cell_m), diagonal = step * std::numbers::sqrt2_v<float>;
  const CellMask walls = mask_of(grid, is_occupied);
  std::vector<float> field(walls.size(), static_cast<float>(reach_m));
  for (std::size_t k = 0; k < field.size(); ++k)
    if (walls[k] != 0) field[k] = 0.0F;
  const auto relax = [&](int x, int y, int dx, int dy) {
    if (!grid.holds(x + dx, y + dy)) return;
    float& here = field[cell_index(grid, x, y)];
    here = std::min(here, field[cell_index(grid, x + dx, y + dy)] + (dx != 0 && dy != 0 ? diagonal : step));
  };
  const auto sweep = [&](int x, int y, int side) {
    relax(x, y, -side, 0);
    for (const int dx : {-1, 0, 1}) relax(x, y, dx, -side);
  };
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) sweep(x, y, 1);
  for (int y = grid.height - 1; y >= 0; --y)
    for (int x = grid.width - 1; x >= 0; --x) sweep(x, y, -1);
  return field;
}

/// Centers of occupied cells, evenly thinned.
std::vector<Eigen::Vector2d> walls_of(const OccupancyGrid& grid) {
  std::vector<Eigen::Vector2d> all, some;
  for_each_cell(grid, [&](std::int8_t percent, const Eigen::Vector2d& center) {
    if (is_occupied(percent)) all.push_back(center);
  });
  const std::size_t every = (all.size() + most_points - 1) / most_points;
  for (std::size_t k = 0; k < all.size(); k += every) some.push_back(all[k]);
  return some;
}

class Search {
 public:
  Search(const OccupancyGrid& map, const OccupancyGrid& ground_truth, const SE2& start)
      : ground_truth_(ground_truth), field_(distances(ground_truth)), walls_(walls_of(map)), start_(start) {
    for (const Eigen::Vector2d& wall : walls_) middle_ += wall / static_cast<double>(walls_.size());
  }

  bool is_possible() const {
    const auto at_wall = [](float distance_m) { return distance_m == 0.0F; };
    return !walls_.empty() && std::any_of(field_.begin(), field_.end(), at_wall);
  }

  SE2 run(double search_m, double search_rad) {
    best_ = score(moved_by(Eigen::Vector3d::Zero()));
    around(Eigen::Vector3d::Zero(), {first_step_m, first_step_m, first_step_rad},
           {search_m + 1e-9, search_m + 1e-9, search_rad + 1e-9});
    Eigen::Vector3d step(first_step_m, first_step_m, first_step_rad);
    for (int k = 0; k < refinements; ++k) {
      step /= 2.0;
      around(at_, step, 1.5 * step);
    }
    return moved_by(at_);
  }

 private:
  /// `change`: x and y in the axes of the ground truth, and the rotation about the center of the map's walls.
  SE2 moved_by(const Eigen::Vector3d& change) const {
    const SO2 rotation = SO2::from_angle(change.z());
    const Eigen::Vector2d middle = start_ * middle_;
    const SE2 moved(rotation, middle - rotation * middle + change.head<2>());
    return moved * start_;
  }

  double score(const SE2& ground_truth_from_map) const {
    double sum = 0.0;
    for (const Eigen::Vector2d& wall : walls_) {
      const Eigen::Vector2i cell = ground_truth_.cell_of(ground_truth_from_map * wall);
      if (ground_truth_.holds(cell.x(), cell.y()))
        sum += reach_m - static_cast<double>(field_[cell_index(ground_truth_, cell.x(), cell.y())]);
    }
    return sum;
  }

  void around(const Eigen::Vector3d& middle, const Eigen::Vector3d& step, const Eigen::Vector3d& reach) {
    const Eigen::Vector3i count = (reach.array() / step.array()).floor().cast<int>();
    for (int yaw = -count.z(); yaw <= count.z(); ++yaw)
      for (int y = -count.y(); y <= count.y(); ++y)
        for (int x = -count.x(); x <= count.x(); ++x) try_at(middle + step.cwiseProduct(Eigen::Vector3d(x, y, yaw)));
  }

  void try_at(const Eigen::Vector3d& change) {
    const double found = score(moved_by(change));
    if (found <= best_) return;
    best_ = found;
    at_ = change;
  }

  const OccupancyGrid& ground_truth_;
  const std::vector<float> field_;
  const std::vector<Eigen::Vector2d> walls_;
  const SE2 start_;
  Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();
  Eigen::Vector3d at_ = Eigen::Vector3d::Zero();
  double best_ = 0.0;
};

}  // namespace

SE2 align_grids(const OccupancyGrid& map, const OccupancyGrid& ground_truth, const SE2& start, double search_m,
                double search_rad) {
  Search search(map, ground_truth, start);
  return search.is_possible() ? search.run(search_m, search_rad) : start;
}

}  // namespace rastro
