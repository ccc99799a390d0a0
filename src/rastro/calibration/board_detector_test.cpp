// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/board_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/calibration/board_dictionary.h"
#include "rastro/calibration/board_rendering_testing.h"
#include "rastro/calibration/boards_testing.h"

namespace rastro {
namespace {

/// How far the corners found are off the truth.
struct Accuracy {
  int images = 0;
  int corners = 0, expected = 0;
  double rms_px = 0.0, worst_px = 0.0;
};

/// The corners of a chessboard may begin at its other end.
bool other_end_first(const DetectedBoard& found, const std::vector<Eigen::Vector2d>& truth) {
  return (found.pixels.front() - truth.front()).norm() > (found.pixels.back() - truth.front()).norm();
}

Accuracy accuracy_of(const Board& board, int frames) {
  const GeneratedBoards made = generate_boards({.seed = 7, .frames = frames, .noise_px = 0.0, .board = board});
  const Lens& lens = made.truth.lenses[0];
  const BoardRenderer renderer(board, lens, 640, 480);
  Random random(1);
  Accuracy accuracy;
  for (std::size_t i = 0; i < made.truth.left_from_board.size(); ++i) {
    const SE3& pose = made.truth.left_from_board[i];
    std::vector<Eigen::Vector2d> truth;
    for (int k = 0; k < board.corner_count(); ++k) {
      const auto seen = lens.project(pose * board_point(made.truth, k));
      truth.push_back(seen ? seen->pixel : Eigen::Vector2d(-1e6, -1e6));
    }
    accuracy.expected += static_cast<int>(made.input.views[i].corners.size());
    const auto found = detect_board(renderer.render(pose, 3.0, random).view(), board);
    if (!found) continue;
    ++accuracy.images;
    const bool turned = board.kind == BoardKind::chessboard && other_end_first(*found, truth);
    for (std::size_t k = 0; k < found->corners.size(); ++k) {
      const auto corner = static_cast<std::size_t>(found->corners[k]);
      const double off = (found->pixels[k] - truth[turned ? truth.size() - 1 - corner : corner]).norm();
      accuracy.rms_px += off * off;
      accuracy.worst_px = std::max(accuracy.worst_px, off);
      ++accuracy.corners;
    }
  }
  accuracy.rms_px = std::sqrt(accuracy.rms_px / std::max(1, accuracy.corners));
  return accuracy;
}

TEST(BoardDetectorTest, ChessboardsAreFoundToATenthOfAPixel) {
  const Accuracy accuracy = accuracy_of({9, 6, 0.025}, 12);
  EXPECT_EQ(accuracy.images, 12);
  EXPECT_EQ(accuracy.corners, accuracy.expected);
  EXPECT_LT(accuracy.rms_px, 0.1);
  EXPECT_LT(accuracy.worst_px, 0.5);
}

TEST(BoardDetectorTest, BoardsWithTagsAreFoundInPartToo) {
  for (const char* text : {"charuco:10x7:0.024:0.016", "charuco:8x6:0.03:0.02:5x5_100", "apriltag:6x5:0.03:0.009"}) {
    const Accuracy accuracy = accuracy_of(parse_board(text), 12);
    EXPECT_EQ(accuracy.images, 12) << text;
    EXPECT_GT(accuracy.corners, 0.8 * accuracy.expected) << text;
    EXPECT_LT(accuracy.rms_px, 0.12) << text;
    EXPECT_LT(accuracy.worst_px, 0.6) << text;
    std::printf("%s: %d of %d corners, %.3f px RMS, %.3f px worst\n", text, accuracy.corners, accuracy.expected,
                accuracy.rms_px, accuracy.worst_px);
  }
}

/// A grid of tags as Kalibr prints it: a border of two cells, and all tags turned by `turns` times 90 degrees.
GrayImage kalibr_grid(const Board& board, int cell, int gap, std::size_t turns, int left, int top) {
  GrayImage image(640, 480);
  const auto fill = [&](int x, int y, int size, std::uint8_t value) {
    for (int row = y; row < y + size; ++row) std::fill(image.row(row) + x, image.row(row) + x + size, value);
  };
  for (int y = 0; y < 480; ++y) std::fill(image.row(y), image.row(y) + 640, std::uint8_t{200});
  const int tag = 10 * cell, step = tag + gap;
  for (int y = 0; y <= board.rows; ++y)
    for (int x = 0; x <= board.columns; ++x) fill(left + x * step - gap, top + y * step - gap, gap, 40);
  for (int id = 0; id < board.columns * board.rows; ++id) {
    const int x0 = left + id % board.columns * step, y0 = top + (board.rows - 1 - id / board.columns) * step;
    fill(x0, y0, tag, 40);
    const auto cells = tag_cells(board.tags, id);
    for (std::size_t y = 1; y < 7; ++y)
      for (std::size_t x = 1; x < 7; ++x) {
        std::size_t u = x, v = y;
        for (std::size_t k = 0; k < turns; ++k) u = std::exchange(v, 7 - u);
        if (!cells[v][u]) fill(x0 + cell * static_cast<int>(x + 1), y0 + cell * static_cast<int>(y + 1), cell, 200);
      }
  }
  return image;
}

TEST(BoardDetectorTest, KalibrsGridsAreFoundHoweverTheirTagsAreTurned) {
  const Board board = parse_board("apriltag:4x3:0.08:0.024");
  const std::vector<Eigen::Vector2d> points = board.points();
  for (const std::size_t turns : {0U, 1U, 2U, 3U}) {
    const auto found = detect_board(kalibr_grid(board, 8, 24, turns, 120, 90).view(), board);
    ASSERT_TRUE(found) << turns;
    EXPECT_EQ(found->corners.size(), points.size());
    for (std::size_t k = 0; k < found->corners.size(); ++k) {
      const Eigen::Vector2d& point = points[static_cast<std::size_t>(found->corners[k])];
      EXPECT_LT((found->pixels[k] - (1000.0 * point + Eigen::Vector2d(119.5, 89.5))).norm(), 0.2) << turns;
    }
  }
}

TEST(BoardDetectorTest, NoBoardIsNotFound) {
  Random random(2);
  GrayImage noise(640, 480);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) noise.at(x, y) = static_cast<std::uint8_t>(random.below(256));
  for (const char* text : {"chessboard:9x6:0.025", "charuco:10x7:0.024:0.018", "apriltag:6x5:0.03:0.009"}) {
    const Board board = parse_board(text);
    EXPECT_FALSE(detect_board(GrayImage(640, 480).view(), board));
    EXPECT_FALSE(detect_board(noise.view(), board));
    EXPECT_FALSE(detect_board(GrayImage(3, 2).view(), board));
    EXPECT_FALSE(detect_board(GrayImage().view(), board));
  }
}

TEST(BoardTest, TextsAreReadAndWritten) {
  for (const char* text : {"chessboard:9x6:0.025", "charuco:8x6:0.03:0.022:5x5_100", "apriltag:6x6:0.088:0.0264:36h11"})
    EXPECT_EQ(board_text(parse_board(text)), text);
  EXPECT_EQ(parse_board("charuco:8x6:0.03:0.022").corner_count(), 35);
  EXPECT_EQ(parse_board("apriltag:6x6:0.03:0.009").corner_count(), 144);
  EXPECT_EQ(parse_board("charuco:8x6:0.03:0.022").tags, "4x4_50");
  for (const char* text : {"",
                           "chessboard",
                           "chessboard:9x6",
                           "chessboard:9x6:0",
                           "chessboard:9x6:x",
                           "chessboard:2x6:0.1",
                           "circles:9x6:0.1",
                           "chessboard:-9x6:0.1",
                           "chessboard:9x6:nan",
                           "chessboard:99999999999x6:1",
                           "chessboard:9x6:0.1:0.2",
                           "chessboard:9x6:25",
                           "charuco:8x6:0.03",
                           "charuco:8x6:0.03:0.03",
                           "charuco:3x6:0.03:0.02",
                           "charuco:8x6:0.03:0.02:9x9_50",
                           "charuco:20x20:0.03:0.02",
                           "apriltag:6x6:0.03:0.3",
                           "apriltag:6x6:0.03:0.009:4x4_50",
                           "apriltag:40x40:0.03:0.009",
                           "apriltag:6x6:0.03:0.009:36h11:1"})
    EXPECT_THROW(parse_board(text), Error) << text;
}

TEST(BoardTest, PrintsHaveEveryBlackRectangleInMillimeters) {
  const Board board = parse_board("chessboard:9x6:0.025");
  EXPECT_EQ(black_rectangles(board).size(), 35U);
  EXPECT_THAT(board_svg(board), testing::HasSubstr("width=\"300mm\" height=\"237mm\""));
  EXPECT_THAT(board_svg(board), testing::HasSubstr("M25 25h25v25h-25z"));
  EXPECT_THAT(board_svg(board), testing::HasSubstr("--board chessboard:9x6:0.025"));
  const std::string pdf = board_pdf(board);
  EXPECT_THAT(pdf, testing::StartsWith("%PDF-1.4"));
  EXPECT_THAT(pdf, testing::HasSubstr("MediaBox [0 0 850.3937 671.8110]"));
  EXPECT_THAT(pdf, testing::HasSubstr("\n25.00000 187.00000 25.00000 25.00000 re\n"));
  // The table of objects stands where the end says, and the first object where the table says.
  const std::size_t table = std::stoul(pdf.substr(pdf.rfind("startxref") + 10));
  EXPECT_EQ(pdf.substr(table, 4), "xref");
  EXPECT_EQ(pdf.substr(std::stoul(pdf.substr(pdf.find("65535 f") + 9, 10)), 7), "1 0 obj");
}

}  // namespace
}  // namespace rastro
