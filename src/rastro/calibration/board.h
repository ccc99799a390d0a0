// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace rastro {

/// A chessboard: its inner corners, where four squares meet.
struct Board {
  int columns = 0;        ///< Inner corners along x.
  int rows = 0;           ///< Inner corners along y.
  double square_m = 0.0;  ///< Side of a square.

  int corner_count() const { return columns * rows; }
  /// Corners in the plane of the board, row by row, the first at (0, 0); meters.
  std::vector<Eigen::Vector2d> points() const;
};

/// Reads "chessboard:9x6:0.025": inner corners along x and y, side of a square in meters. Throws Error for anything
/// else, for fewer than 3 corners a side, and for squares that are not positive.
Board parse_board(std::string_view text);

/// The board as an SVG to print at 100 %, with a margin of a square and a ruler of 100 mm below to check the print.
std::string board_svg(const Board& board);

}  // namespace rastro
