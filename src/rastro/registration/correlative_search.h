// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "rastro/map/grid/log_odds_grid.h"
#include "rastro/math/se2.h"

namespace rastro {

struct CorrelativeWindow {
  double reach_m = 0.5;      ///< Half the side of the searched square, meters.
  double reach_rad = 0.35;   ///< Half the searched range of rotation.
  double least_score = 0.5;  ///< Minimum mean of the map at the returns.
};

struct CorrelativeFit {
  SE2 map_from_body;
  double score = 0.0;
};

/// A probability map with its maxima over squares of 1, 2, 4, ... cells: upper bounds with which the search skips whole
/// regions and still finds the optimum (Hess et al. 2016, section V; Olson 2009).
class CorrelativeMap {
 public:
  /// Copies the map, with maxima over squares of up to 2^(levels - 1) cells; `levels` >= 1.
  CorrelativeMap(const ProbabilityView& map, int levels);

  /// The best pose on a raster of one cell and of the rotation that moves nine in ten returns by at most a cell, within
  /// the window about `guess`; nullopt if none reaches least_score. Of equal ones one of smallest rotation is returned,
  /// the same on every run.
  std::optional<CorrelativeFit> search(std::span<const Eigen::Vector2d> points, const SE2& guess,
                                       const CorrelativeWindow& window) const;

 private:
  struct Level {
    int size = 1;  ///< Side of the square of the maximum.
    int width = 0, height = 0;
    std::vector<std::uint8_t> cells;  ///< The first one is that of (x - size + 1, y - size + 1).
  };
  struct Candidate;
  class Search;

  static Level widened(const Level& fine);

  double cell_m_;
  Eigen::Vector2d origin_;
  std::vector<Level> levels_;
};

}  // namespace rastro
