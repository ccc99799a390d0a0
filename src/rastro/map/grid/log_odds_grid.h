// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/map/grid/log_odds_model.h"
#include "rastro/map/grid/scan_cells.h"

namespace rastro {

/// Read-only occupancy probabilities of the cells, for the matchers. Values are 0 (free) to 255 (occupied), 128 where
/// unknown. Points into the grid it comes from.
struct ProbabilityView {
  const std::uint8_t* cells = nullptr;
  int width = 0, height = 0;
  double cell_m = 0.05;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< Of the corner of cell (0, 0), in the grid's frame.
};

/// An occupancy grid in log-odds that grows with the scans inserted (Moravec and Elfes 1985; Thrun et al. 2005, 9.2).
/// It holds every cell of its bounding box, as the matchers read it: for the small area of a submap. For a whole map
/// there is OccupancyMapper.
class LogOddsGrid {
 public:
  LogOddsGrid(double cell_m, const LogOddsModel& model) : cell_m_(cell_m), steps_(model) {}

  /// Inserts beams from `sensor` to each of `returns`, both in the grid's frame: free along the beam, occupied at its
  /// end. A cell is updated once per scan, and a return in it outweighs a beam through it. Returns farther than 32,768
  /// cells from the sensor are left out.
  void insert(const Eigen::Vector2d& sensor, std::span<const Eigen::Vector2d> returns);

  ProbabilityView view() const;
  /// Frees the memory that only insert() needs.
  void freeze();
  /// Memory of the cells.
  std::size_t bytes() const;

 private:
  void grow_to_hold(const ScanCells& scan);
  void draw_beam(const Eigen::Vector2i& from, const Eigen::Vector2i& to);
  void set(std::size_t cell, std::int16_t log_odds) {
    log_odds_[cell] = log_odds;
    probability_[cell] = steps_.probability_of(log_odds);
  }
  std::size_t index_of(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>(cell.y() - box_.first.y()) * static_cast<std::size_t>(box_.size.x()) +
           static_cast<std::size_t>(cell.x() - box_.first.x());
  }

  double cell_m_;
  LogOddsSteps steps_;
  CellBox box_;
  std::vector<std::int16_t> log_odds_;
  std::vector<std::uint8_t> probability_;
  std::vector<std::uint32_t> touched_;  ///< Number of the scan that last changed the cell, twice; odd: by a return.
  std::uint32_t scans_ = 0;
};

}  // namespace rastro
