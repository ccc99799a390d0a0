// SPDX-License-Identifier: Apache-2.0
// In how many good views boards are found, and how exactly.
#include <gtest/gtest.h>

#include "rastro/calibration/board_detector.h"
#include "rastro/calibration/board_views_testing.h"

namespace rastro {
namespace {

struct ViewCase {
  const char* name;
  const char* board;
};

class BoardViewsTest : public testing::TestWithParam<ViewCase> {};

/// From each corner found to its true position, pixels. A chessboard may begin at its other end.
std::vector<double> distances(const DetectedBoard& found, const GoodView& view, const Board& board) {
  const std::vector<Eigen::Vector2d>& truth = view.corners;
  const bool turned = board.kind == BoardKind::chessboard &&
                      (found.pixels.front() - truth.front()).norm() > (found.pixels.back() - truth.front()).norm();
  std::vector<double> result;
  for (std::size_t k = 0; k < found.corners.size(); ++k) {
    const auto corner = static_cast<std::size_t>(found.corners[k]);
    result.push_back((found.pixels[k] - truth[turned ? truth.size() - 1 - corner : corner]).norm());
  }
  return result;
}

TEST_P(BoardViewsTest, AreFoundInAllButOneOfFifty) {
  constexpr int views = 100;
  const Board board = parse_board(GetParam().board);
  GoodViews good(board, 201);
  int found = 0, exact = 0, corners = 0;
  for (int k = 0; k < views; ++k) {
    const GoodView view = good.next();
    const auto seen = detect_board(view.image.view(), board);
    if (!seen) continue;
    found += 2 * seen->corners.size() >= view.corners.size() ? 1 : 0;
    for (const double off : distances(*seen, view, board)) {
      exact += off < 0.5 ? 1 : 0;
      ++corners;
    }
  }
  EXPECT_GE(found, 98);
  EXPECT_GE(exact, 0.998 * corners);
  std::printf("%s: found in %d of %d, %d of %d corners within 0.5 px\n", GetParam().name, found, views, exact, corners);
}

constexpr ViewCase view_cases[] = {{"chessboard", "chessboard:9x6:0.025"},
                                   {"charuco", "charuco:8x6:0.03:0.02"},
                                   {"apriltag", "apriltag:5x4:0.036:0.0108"}};

INSTANTIATE_TEST_SUITE_P(Boards, BoardViewsTest, testing::ValuesIn(view_cases),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace rastro
