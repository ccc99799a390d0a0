// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/occupancy_mapper.h"

namespace rastro {

void OccupancyMapper::insert(const Eigen::Vector2d& sensor, std::span<const Eigen::Vector2d> returns) {
  const ScanCells scan(cell_m_, sensor, returns);
  box_ = box_.grown_to_hold(scan);
  count_scan();
  const auto by_beam = static_cast<std::uint16_t>(2 * scans_), by_return = static_cast<std::uint16_t>(by_beam + 1);
  TiledCells<Cell>::Writer writer(cells_);
  for (const Eigen::Vector2i& end : scan.returns) {
    Cell& cell = writer.at(end.x(), end.y());
    if (cell.touched != by_return) cell = {steps_.after_return(cell.log_odds), by_return};
  }
  for (const Eigen::Vector2i& end : scan.returns) {
    walk_beam<Eigen::Vector2i>(end - scan.sensor, scan.sensor, {1, 0}, {0, 1}, [&](const Eigen::Vector2i& position) {
      Cell& cell = writer.at(position.x(), position.y());
      if (cell.touched < by_beam) cell = {steps_.after_passing_beam(cell.log_odds), by_beam};
    });
  }
}

/// Two bytes a cell are enough: when the number of the scan is at its end, all cells count as untouched and it starts
/// again.
void OccupancyMapper::count_scan() {
  constexpr std::uint16_t last_scan = 32767;
  if (scans_ == last_scan) {
    cells_.change_each([](Cell& cell) { cell.touched = 0; });
    scans_ = 0;
  }
  ++scans_;
}

OccupancyGrid OccupancyMapper::grid() const {
  OccupancyGrid grid;
  grid.cell_m = cell_m_;
  grid.origin = cell_m_ * box_.first.cast<double>();
  grid.width = box_.size.x();
  grid.height = box_.size.y();
  TiledCells<std::int8_t>::Writer writer(grid.percent);
  cells_.for_each([&](int x, int y, const Cell& cell) {
    const std::int8_t percent = percent_of(cell);
    if (percent != OccupancyGrid::unknown) writer.at(x - box_.first.x(), y - box_.first.y()) = percent;
  });
  return grid;
}

std::int8_t OccupancyMapper::percent_of(const Cell& cell) const {
  const std::uint8_t probability = steps_.probability_of(cell.log_odds);
  if (probability == LogOddsSteps::nothing_known) return OccupancyGrid::unknown;
  return static_cast<std::int8_t>((100 * probability + 127) / 255);
}

}  // namespace rastro
