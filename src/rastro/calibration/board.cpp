// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/board.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro {
namespace {

constexpr int most_corners = 100;  // A side.

template <typename Number>
bool parse_whole(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

[[noreturn]] void fail_board(std::string_view what, std::string_view text) {
  throw Error(
      what, fmt::format("--board {}", one_line(text, 60)),
      "write chessboard:COLUMNSxROWS:METERS with the inner corners and the side of a square, as chessboard:9x6:0.025");
}

}  // namespace

std::vector<Eigen::Vector2d> Board::points() const {
  std::vector<Eigen::Vector2d> points;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) points.emplace_back(x * square_m, y * square_m);
  return points;
}

Board parse_board(std::string_view text) {
  const std::size_t first = text.find(':'), cross = text.find('x', first == text.npos ? 0 : first);
  const std::size_t second = cross == text.npos ? text.npos : text.find(':', cross);
  if (first == text.npos || cross == text.npos || second == text.npos) fail_board("is no board", text);
  if (text.substr(0, first) != "chessboard") fail_board("is a kind of board that rastro does not know", text);
  Board board;
  if (!parse_whole(text.substr(first + 1, cross - first - 1), board.columns) ||
      !parse_whole(text.substr(cross + 1, second - cross - 1), board.rows) ||
      !parse_whole(text.substr(second + 1), board.square_m))
    fail_board("holds something that is no number", text);
  if (board.columns < 3 || board.rows < 3 || board.columns > most_corners || board.rows > most_corners)
    fail_board("needs 3 to 100 inner corners a side", text);
  if (!(board.square_m > 1e-6 && board.square_m < 100.0)) fail_board("has squares of no plausible size", text);
  return board;
}

std::string board_svg(const Board& board) {
  const double square = board.square_m * 1000.0;
  const int columns = board.columns + 1, rows = board.rows + 1;
  const double width = (columns + 2) * square, height = (rows + 2) * square + 12.0;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}mm\" height=\"{1:g}mm\" viewBox=\"0 0 {0:g} {1:g}\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<path fill=\"black\" d=\"",
      width, height);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      if ((x + y) % 2 == 0)
        svg += fmt::format("M{:g} {:g}h{:g}v{:g}h{:g}z", (x + 1) * square, (y + 1) * square, square, square, -square);
  const double ruler = height - 10.0;
  svg += fmt::format(
      "\"/>\n<path stroke=\"black\" stroke-width=\"0.3\" fill=\"none\" d=\"M{0:g} {1:g}v-3m0 1.5h100m0 -1.5v3\"/>\n"
      "<text x=\"{0:g}\" y=\"{2:g}\" font-family=\"sans-serif\" font-size=\"4\">100 mm: measure it. "
      "rastro calibrate --board chessboard:{3}x{4}:{5:g}</text>\n</svg>\n",
      square, ruler, ruler + 5.0, board.columns, board.rows, board.square_m);
  return svg;
}

}  // namespace rastro
