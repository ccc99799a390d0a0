// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/board.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/calibration/board_dictionary.h"

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
      "write chessboard:9x6:0.025 (inner corners, side of a square in meters), charuco:8x6:0.03:0.022 (squares, "
      "side of a square and of a tag) or apriltag:6x6:0.03:0.009 (tags, side of a tag, gap between two)");
}

double parse_size(std::string_view field, std::string_view text) {
  double size = 0.0;
  if (!parse_whole(field, size)) fail_board("holds something that is no number", text);
  constexpr double largest_m = 2.0;
  if (size > largest_m)
    fail_board(fmt::format("has a side of {:g} m; sizes are in meters, {:g} mm would be {:g}", size, size, 1e-3 * size),
               text);
  if (!(size > 1e-6)) fail_board("has a size that is not plausible", text);
  return size;
}

void parse_counts(std::string_view field, std::string_view text, Board& board) {
  const std::size_t cross = field.find('x');
  if (cross == field.npos) fail_board("is no board", text);
  if (!parse_whole(field.substr(0, cross), board.columns) || !parse_whole(field.substr(cross + 1), board.rows))
    fail_board("holds something that is no number", text);
  const int fewest = board.kind == BoardKind::charuco ? 4 : board.kind == BoardKind::apriltag ? 2 : 3;
  if (std::min(board.columns, board.rows) < fewest || std::max(board.columns, board.rows) > most_corners)
    fail_board(fmt::format("needs {} to {} {} a side", fewest, most_corners,
                           board.kind == BoardKind::charuco    ? "squares"
                           : board.kind == BoardKind::apriltag ? "tags"
                                                               : "inner corners"),
               text);
}

/// The fields after the size of squares or tags.
void parse_tags(const std::vector<std::string_view>& fields, std::string_view text, Board& board) {
  const double second = parse_size(fields[3], text);
  if (board.kind == BoardKind::charuco) {
    board.tag_m = second;
    if (second > 0.95 * board.square_m) fail_board("has tags that fill their squares", text);
  } else {
    board.tag_m = board.square_m;
    board.square_m += second;
    if (second > board.tag_m) fail_board("has gaps (in meters) that are larger than its tags", text);
  }
  board.tags = fields.size() > 4 ? std::string(fields[4]) : board.kind == BoardKind::charuco ? "4x4_50" : "36h11";
  const int known = dictionary_size(board.tags);
  const int needed = static_cast<int>(board_tags(board).size());
  if (known == 0 || (board.kind == BoardKind::apriltag && !is_apriltag_family(board.tags)))
    fail_board("has tags of a dictionary that is not known (4x4_50 to 7x7_1000; 16h5, 25h9, 36h10, 36h11)", text);
  if (needed > known) fail_board(fmt::format("needs {} tags, and {} has {}", needed, board.tags, known), text);
}

/// Dark cells of a tag, joined along each row.
void add_tag(const BoardTag& tag, const Board& board, std::vector<BoardRectangle>& result) {
  const std::vector<std::vector<bool>> cells = tag_cells(board.tags, tag.id);
  const double side = board.tag_m / static_cast<double>(cells.size());
  for (std::size_t y = 0; y < cells.size(); ++y)
    for (std::size_t x = 0; x < cells.size();) {
      std::size_t end = x;
      while (end < cells.size() && cells[y][end]) ++end;
      if (end > x)
        result.push_back({tag.upper_left.x() + static_cast<double>(x) * side,
                          tag.upper_left.y() + static_cast<double>(y) * side, static_cast<double>(end - x) * side,
                          side});
      x = std::max(end, x + 1);
    }
}

/// The board's squares (tags and gaps of a grid), without margin.
BoardRectangle outline(const Board& board) {
  const double gap = board.square_m - board.tag_m;
  if (board.kind == BoardKind::apriltag)
    return {-gap, -gap, board.columns * board.square_m + gap, board.rows * board.square_m + gap};
  const int more = board.kind == BoardKind::chessboard ? 1 : 0;
  return {-board.square_m, -board.square_m, (board.columns + more) * board.square_m,
          (board.rows + more) * board.square_m};
}

struct Sheet {
  double width_mm, height_mm, left_mm, top_mm, ruler_mm;
};

Sheet sheet_of(const Board& board) {
  const BoardRectangle around = outline(board);
  const double margin = board.square_m;
  const double width = (around.width + 2.0 * margin) * 1e3, height = (around.height + 2.0 * margin) * 1e3 + 12.0;
  return {width, height, (margin - around.x) * 1e3, (margin - around.y) * 1e3, height - 10.0};
}

std::string advice(const Board& board) {
  return fmt::format("100 mm: measure it. rastro calibrate --board {}", board_text(board));
}

}  // namespace

std::vector<Eigen::Vector2d> Board::points() const {
  std::vector<Eigen::Vector2d> points;
  if (kind == BoardKind::apriltag) {
    for (const BoardTag& tag : board_tags(*this))
      for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}, {0, 1}})
        points.emplace_back(tag.upper_left + tag_m * corner);
    return points;
  }
  const int less = kind == BoardKind::charuco ? 1 : 0;
  for (int y = 0; y < rows - less; ++y)
    for (int x = 0; x < columns - less; ++x) points.emplace_back(x * square_m, y * square_m);
  return points;
}

std::vector<BoardTag> board_tags(const Board& board) {
  std::vector<BoardTag> tags;
  if (board.kind == BoardKind::apriltag)
    for (int y = board.rows - 1; y >= 0; --y)
      for (int x = 0; x < board.columns; ++x)
        tags.push_back({static_cast<int>(tags.size()), {x * board.square_m, y * board.square_m}});
  if (board.kind == BoardKind::charuco)
    for (int y = 0; y < board.rows; ++y)
      for (int x = 1 - y % 2; x < board.columns; x += 2) {
        const double inset = 0.5 * (board.square_m - board.tag_m);
        tags.push_back(
            {static_cast<int>(tags.size()), {(x - 1) * board.square_m + inset, (y - 1) * board.square_m + inset}});
      }
  return tags;
}

Board parse_board(std::string_view text) {
  const std::vector<std::string_view> fields = split(text, ':');
  if (fields.size() < 3) fail_board("is no board", text);
  Board board;
  if (fields[0] == "charuco") {
    board.kind = BoardKind::charuco;
  } else if (fields[0] == "apriltag") {
    board.kind = BoardKind::apriltag;
  } else if (fields[0] != "chessboard") {
    fail_board("is a kind of board that rastro does not know", text);
  }
  const bool plain = board.kind == BoardKind::chessboard;
  if (plain ? fields.size() != 3 : fields.size() < 4 || fields.size() > 5) fail_board("is no board", text);
  parse_counts(fields[1], text, board);
  board.square_m = parse_size(fields[2], text);
  if (!plain) parse_tags(fields, text, board);
  return board;
}

std::string board_text(const Board& board) {
  const std::string counts = fmt::format("{}x{}", board.columns, board.rows);
  if (board.kind == BoardKind::charuco)
    return fmt::format("charuco:{}:{:.6g}:{:.6g}:{}", counts, board.square_m, board.tag_m, board.tags);
  if (board.kind == BoardKind::apriltag)
    return fmt::format("apriltag:{}:{:.6g}:{:.6g}:{}", counts, board.tag_m, board.square_m - board.tag_m, board.tags);
  return fmt::format("chessboard:{}:{:.6g}", counts, board.square_m);
}

std::vector<BoardRectangle> black_rectangles(const Board& board) {
  std::vector<BoardRectangle> result;
  const double square = board.square_m;
  if (board.kind == BoardKind::apriltag) {
    // Where four corners meet, so that each is a saddle, as those of a chessboard.
    const double gap = square - board.tag_m;
    for (int y = 0; y <= board.rows; ++y)
      for (int x = 0; x <= board.columns; ++x) result.push_back({x * square - gap, y * square - gap, gap, gap});
  } else {
    const int more = board.kind == BoardKind::chessboard ? 1 : 0;
    for (int y = 0; y < board.rows + more; ++y)
      for (int x = y % 2; x < board.columns + more; x += 2)
        result.push_back({(x - 1) * square, (y - 1) * square, square, square});
  }
  for (const BoardTag& tag : board_tags(board)) add_tag(tag, board, result);
  return result;
}

std::string board_svg(const Board& board) {
  const Sheet sheet = sheet_of(board);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}mm\" height=\"{1:g}mm\" viewBox=\"0 0 {0:g} {1:g}\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<path fill=\"black\" shape-rendering=\"crispEdges\" d=\"",
      sheet.width_mm, sheet.height_mm);
  for (const BoardRectangle& black : black_rectangles(board))
    svg += fmt::format("M{:.8g} {:.8g}h{:.8g}v{:.8g}h{:.8g}z", sheet.left_mm + black.x * 1e3,
                       sheet.top_mm + black.y * 1e3, black.width * 1e3, black.height * 1e3, -black.width * 1e3);
  svg += fmt::format(
      "\"/>\n<path stroke=\"black\" stroke-width=\"0.3\" fill=\"none\" d=\"M{0:g} {1:g}v-3m0 1.5h100m0 -1.5v3\"/>\n"
      "<text x=\"{0:g}\" y=\"{2:g}\" font-family=\"sans-serif\" font-size=\"4\">{3}</text>\n</svg>\n",
      board.square_m * 1e3, sheet.ruler_mm, sheet.ruler_mm + 5.0, advice(board));
  return svg;
}

std::string board_pdf(const Board& board) {
  constexpr double point = 72.0 / 25.4;  // Per millimeter.
  const Sheet sheet = sheet_of(board);
  const double top = sheet.height_mm, left = board.square_m * 1e3;
  std::string page = fmt::format("{0:.8f} 0 0 {0:.8f} 0 0 cm\n", point);
  for (const BoardRectangle& black : black_rectangles(board))
    page += fmt::format("{:.5f} {:.5f} {:.5f} {:.5f} re\n", sheet.left_mm + black.x * 1e3,
                        top - sheet.top_mm - (black.y + black.height) * 1e3, black.width * 1e3, black.height * 1e3);
  const double ruler = top - sheet.ruler_mm;
  page += fmt::format(
      "f\n0.3 w {0:.5f} {1:.5f} m {0:.5f} {2:.5f} l {0:.5f} {3:.5f} m {4:.5f} {3:.5f} l {4:.5f} {1:.5f} m {4:.5f} "
      "{2:.5f} l S\nBT /F1 4 Tf {0:.5f} {5:.5f} Td ({6}) Tj ET\n",
      left, ruler, ruler + 3.0, ruler + 1.5, left + 100.0, ruler - 5.0, advice(board));
  const std::string objects[] = {
      "<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R /Resources << /Font << "
                  "/F1 5 0 R >> >> >>",
                  sheet.width_mm * point, sheet.height_mm * point),
      fmt::format("<< /Length {} >>\nstream\n{}endstream", page.size(), page),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string pdf = "%PDF-1.4\n", table = "xref\n0 6\n0000000000 65535 f \n";
  int number = 0;
  for (const std::string& object : objects) {
    table += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", ++number, object);
  }
  const std::size_t at = pdf.size();
  return pdf + table + fmt::format("trailer\n<< /Size 6 /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n", at);
}

}  // namespace rastro
