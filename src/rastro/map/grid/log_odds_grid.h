// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/map/grid/occupancy_grid.h"
#include "rastro/math/se2.h"

namespace rastro {

/// The update of the cells by one scan. The defaults are those of Hector SLAM (Kohlbrecher et al. 2011).
struct LogOddsModel {
  double occupied_probability = 0.9;  ///< Of a cell with a return, from this scan alone; above 0.5.
  double free_probability = 0.4;      ///< Of a cell a beam went through; below 0.5.
  double largest_log_odds = 6.0;      ///< Bound on the log-odds, so that a cell can still change.
};

/// Read-only occupancy probabilities of the cells, for the matchers. Values are 0 (free) to 255 (occupied), 128 where
/// unknown. Points into the grid it comes from.
struct ProbabilityView {
  const std::uint8_t* cells = nullptr;
  int width = 0, height = 0;
  double cell_m = 0.05;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< Of the corner of cell (0, 0), in the grid's frame.
};

/// An occupancy grid in log-odds that grows with the scans inserted (Moravec and Elfes 1985; Thrun et al. 2005, 9.2).
class LogOddsGrid {
 public:
  LogOddsGrid(double cell_m, const LogOddsModel& model);

  /// Inserts beams from `sensor` to each of `returns`, both in the grid's frame: free along the beam, occupied at its
  /// end. A cell is updated once per scan, and a return in it outweighs a beam through it. Returns farther than 32,768
  /// cells from the sensor are left out.
  void insert(const Eigen::Vector2d& sensor, std::span<const Eigen::Vector2d> returns);

  ProbabilityView view() const;
  /// Frees the memory that only insert() needs.
  void freeze();

 private:
  void grow_to_hold(const Eigen::Vector2i& least, const Eigen::Vector2i& most);
  Eigen::Vector2i cell_of(const Eigen::Vector2d& point) const;
  void draw_beam(const Eigen::Vector2i& from, const Eigen::Vector2i& to);
  void add(std::size_t cell, int log_odds);
  std::size_t index_of(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>(cell.y() - first_.y()) * static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(cell.x() - first_.x());
  }

  double cell_m_;
  int occupied_step_, free_step_, largest_;
  std::vector<std::uint8_t> probability_of_;  ///< Of each log-odds value from -largest_ on.
  Eigen::Vector2i first_ = Eigen::Vector2i::Zero();
  Eigen::Vector2i size_ = Eigen::Vector2i::Zero();
  std::vector<std::int16_t> log_odds_;
  std::vector<std::uint8_t> probability_;
  std::vector<std::uint32_t> touched_;  ///< Number of the scan that last changed the cell, twice; odd: by a return.
  std::uint32_t scans_ = 0;
};

/// As percent; unknown where no beam passed.
OccupancyGrid to_occupancy(const ProbabilityView& view);

}  // namespace rastro
