// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/scan_cells.h"

#include <cmath>

namespace rastro {
namespace {

constexpr int farthest_cell = 32768;
constexpr int spare_cells = 64;

}  // namespace

ScanCells::ScanCells(double cell_m, const Eigen::Vector2d& sensor_position,
                     std::span<const Eigen::Vector2d> return_positions) {
  const auto cell_of = [cell_m](const Eigen::Vector2d& point) {
    return Eigen::Vector2i(static_cast<int>(std::floor(point.x() / cell_m)),
                           static_cast<int>(std::floor(point.y() / cell_m)));
  };
  sensor = least = most = cell_of(sensor_position);
  for (const Eigen::Vector2d& position : return_positions) {
    const Eigen::Vector2i end = cell_of(position);
    if ((end - sensor).cwiseAbs().maxCoeff() >= farthest_cell) continue;
    least = least.cwiseMin(end);
    most = most.cwiseMax(end);
    returns.push_back(end);
  }
}

bool CellBox::holds(const ScanCells& scan) const {
  return size.x() > 0 && (scan.least.array() >= first.array()).all() &&
         (scan.most.array() < (first + size).array()).all();
}

CellBox CellBox::grown_to_hold(const ScanCells& scan) const {
  if (holds(scan)) return *this;
  Eigen::Vector2i least = scan.least.array() - spare_cells, end = scan.most.array() + spare_cells + 1;
  if (size.x() > 0) {
    least = least.cwiseMin(first);
    end = end.cwiseMax(first + size);
  }
  return {least, end - least};
}

}  // namespace rastro
