// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace rastro {

enum class BoardKind {
  chessboard,  ///< Seen whole or not at all.
  charuco,     ///< A chessboard with a numbered tag in each white square: may be seen in part.
  apriltag,    ///< Numbered tags with black squares where their corners meet, as Kalibr's: may be seen in part.
};

/// A flat board. Its frame: x to the right, y down, as it is printed.
struct Board {
  int columns = 0;        ///< Inner corners of a chessboard, squares of a ChArUco board, tags of a grid: along x.
  int rows = 0;           ///< The same along y.
  double square_m = 0.0;  ///< Side of a square; of a grid of tags, from one tag to the next.
  BoardKind kind = BoardKind::chessboard;
  double tag_m = 0.0;     ///< Side of the tags, with their black border; 0 without.
  std::string tags = {};  ///< Their dictionary: "4x4_50", "36h11".

  int corner_count() const { return static_cast<int>(points().size()); }
  /// Corners in the plane of the board, meters. Of chessboards and ChArUco boards the inner corners row by row, the
  /// first at (0, 0); of a grid the corners of each tag, clockwise from the upper left, which is at (0, 0) for the tag
  /// at the upper left.
  std::vector<Eigen::Vector2d> points() const;
};

/// A tag of a board.
struct BoardTag {
  int id = 0;                  ///< In its dictionary.
  Eigen::Vector2d upper_left;  ///< In the board's frame, meters.
};
/// ChArUco: row by row in the white squares, the first square is black. Grid: row by row from the lower left up.
std::vector<BoardTag> board_tags(const Board& board);

/// Reads "chessboard:9x6:0.025" (inner corners, side of a square), "charuco:8x6:0.03:0.022[:4x4_50]" (squares, side of
/// a square and of a tag, dictionary) or "apriltag:6x6:0.03:0.009[:36h11]" (tags, side of a tag, gap between two). All
/// in meters. Throws Error for anything else, for too few corners, and for sizes that are not possible.
Board parse_board(std::string_view text);
/// The same text again.
std::string board_text(const Board& board);

/// A rectangle in the board's frame, meters.
struct BoardRectangle {
  double x = 0.0, y = 0.0, width = 0.0, height = 0.0;
};
/// What is black.
std::vector<BoardRectangle> black_rectangles(const Board& board);

/// The board as an SVG or PDF to print at 100 %, with a margin of a square and a ruler of 100 mm below to check the
/// print.
std::string board_svg(const Board& board);
std::string board_pdf(const Board& board);

}  // namespace rastro
