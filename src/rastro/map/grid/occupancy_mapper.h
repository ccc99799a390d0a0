// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "rastro/map/grid/log_odds_model.h"
#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/map/grid/scan_cells.h"
#include "rastro/map/grid/tiled_cells.h"

namespace rastro {

/// Makes the occupancy grid of a whole map from its scans. The values are those of LogOddsGrid; memory is that of the
/// area the beams passed.
class OccupancyMapper {
 public:
  OccupancyMapper(double cell_m, const LogOddsModel& model) : cell_m_(cell_m), steps_(model) {}

  /// As LogOddsGrid::insert().
  void insert(const Eigen::Vector2d& sensor, std::span<const Eigen::Vector2d> returns);
  /// Unknown where no beam passed.
  OccupancyGrid grid() const;
  std::size_t tiles() const { return cells_.tiles(); }

 private:
  struct Cell {
    std::int16_t log_odds = 0;
    std::uint16_t touched = 0;  ///< As in LogOddsGrid.
  };

  void count_scan();
  std::int8_t percent_of(const Cell& cell) const;

  double cell_m_;
  LogOddsSteps steps_;
  CellBox box_;
  TiledCells<Cell> cells_{Cell{}};
  std::uint16_t scans_ = 0;
};

}  // namespace rastro
