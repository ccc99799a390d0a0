// SPDX-License-Identifier: Apache-2.0
// --board and --make-board: either an Error of one line, or a board whose points, tags and text are sound.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/calibration/board.h"

namespace {

void expect(bool promise) {
  if (!promise) std::abort();
}

void expect_sound(const rastro::Board& board) {
  const auto points = board.points();
  expect(points.size() >= 9 && static_cast<int>(points.size()) == board.corner_count());
  for (const auto& point : points) expect(point.allFinite());
  const auto tags = board_tags(board);
  expect((board.kind == rastro::BoardKind::chessboard) == tags.empty());
  for (const auto& tag : tags) expect(tag.upper_left.allFinite());
  const rastro::Board again = rastro::parse_board(board_text(board));
  expect(again.kind == board.kind && again.columns == board.columns && again.rows == board.rows);
  expect(again.tags == board.tags && std::abs(again.square_m - board.square_m) <= 1e-5 * board.square_m &&
         std::abs(again.tag_m - board.tag_m) <= 1e-5 * board.square_m);
  // Large boards make large drawings.
  if (points.size() > 400) return;
  for (const auto& black : black_rectangles(board))
    expect(std::isfinite(black.x + black.y) && black.width > 0.0 && black.height > 0.0);
  expect(board_svg(board).ends_with("</svg>\n") && board_pdf(board).starts_with("%PDF"));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    expect_sound(rastro::parse_board({reinterpret_cast<const char*>(data), size}));
  } catch (const rastro::Error& error) {
    expect(std::string_view(error.what()).find('\n') == std::string_view::npos);
  }
  return 0;
}
