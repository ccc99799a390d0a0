// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/octree/ray_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rastro::detail {
namespace {

constexpr double middle_cell = 32768.0;

CellKey packed(const std::array<std::int64_t, 3>& cell) {
  return static_cast<CellKey>(cell[0]) | static_cast<CellKey>(cell[1]) << 16 | static_cast<CellKey>(cell[2]) << 32;
}

void make_set(std::vector<CellKey>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

}  // namespace

RayCells::RayCells(const Eigen::Vector3d& origin, double resolution_m) : origin_(origin), resolution_m_(resolution_m) {}

bool RayCells::is_inside(const Eigen::Vector3d& position) const {
  return position.cwiseAbs().maxCoeff() / resolution_m_ < middle_cell - 2.0;
}

CellKey RayCells::cell_of(const Eigen::Vector3d& position) const {
  std::array<std::int64_t, 3> cell;
  for (int axis = 0; axis < 3; ++axis)
    cell[static_cast<std::size_t>(axis)] =
        static_cast<std::int64_t>(std::floor(position[axis] / resolution_m_) + middle_cell);
  return packed(cell);
}

void RayCells::add(const Eigen::Vector3d& end, bool hit) {
  if (!is_inside(end) || !is_inside(origin_)) return;
  rays_.push_back({cell_of(end), end});
  if (hit) hits_.push_back(rays_.back().cell);
}

void RayCells::finish() {
  make_set(hits_);
  // One ray per end cube: the others pass through nearly the same cubes.
  const auto by_cell = [](const Ray& a, const Ray& b) { return a.cell < b.cell; };
  std::stable_sort(rays_.begin(), rays_.end(), by_cell);
  const auto same = [](const Ray& a, const Ray& b) { return a.cell == b.cell; };
  rays_.erase(std::unique(rays_.begin(), rays_.end(), same), rays_.end());
  for (const Ray& ray : rays_) pass(ray);
  make_set(free_);
  std::vector<CellKey> free;
  std::set_difference(free_.begin(), free_.end(), hits_.begin(), hits_.end(), std::back_inserter(free));
  free_.swap(free);
  rays_.clear();
}

/// Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray tracing".
void RayCells::pass(const Ray& ray) {
  const Eigen::Vector3d along = ray.end - origin_;
  std::array<std::int64_t, 3> cell{}, step{};
  Eigen::Vector3d next, per_cell;
  std::int64_t left = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const double from = origin_[axis] / resolution_m_ + middle_cell, to = ray.end[axis] / resolution_m_ + middle_cell;
    cell[k] = static_cast<std::int64_t>(std::floor(from));
    left += std::abs(static_cast<std::int64_t>(std::floor(to)) - cell[k]);
    step[k] = along[axis] > 0.0 ? 1 : -1;
    const double length = std::abs(along[axis]) / resolution_m_;
    per_cell[axis] = length > 0.0 ? 1.0 / length : std::numeric_limits<double>::infinity();
    const double to_border = along[axis] > 0.0 ? std::floor(from) + 1.0 - from : from - std::floor(from);
    next[axis] = length > 0.0 ? to_border * per_cell[axis] : std::numeric_limits<double>::infinity();
  }
  for (; left > 0; --left) {
    free_.push_back(packed(cell));
    int axis = 0;
    next.minCoeff(&axis);
    cell[static_cast<std::size_t>(axis)] += step[static_cast<std::size_t>(axis)];
    next[axis] += per_cell[axis];
  }
}

}  // namespace rastro::detail
