// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/live_assistant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/calibration/boards_testing.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::IsEmpty;
using Answer = LiveAssistant::Answer;

DetectedBoard moved(DetectedBoard board, const Eigen::Vector2d& by) {
  for (Eigen::Vector2d& pixel : board.pixels) pixel += by;
  return board;
}

TEST(LiveAssistantTest, TakesStillBoardsUntilNothingIsMissing) {
  const GeneratedBoards made = generate_boards({.seed = 5, .frames = 150, .noise_px = 0.1});
  LiveAssistant assistant({9, 6, 0.025}, 640, 480);
  EXPECT_THAT(assistant.missing(), Contains("the whole image"));
  EXPECT_THAT(assistant.missing(), Contains("tilted boards"));
  EXPECT_EQ(assistant.offer(std::nullopt, "0"), Answer::no_board);
  std::size_t shown = 0;
  for (const BoardView& view : made.input.views) {
    if (assistant.enough()) break;
    const DetectedBoard board{view.corners, view.pixels};
    const std::string name = std::to_string(shown++);
    EXPECT_EQ(assistant.offer(moved(board, {40.0, 0.0}), name), Answer::moving) << "from elsewhere";
    EXPECT_EQ(assistant.offer(moved(board, {8.0, 0.0}), name), Answer::moving) << "by 32 pixels an image";
    EXPECT_EQ(assistant.offer(board, name), Answer::moving) << "by 8 pixels an image";
    const std::size_t before = assistant.input().views.size();
    const Answer still = assistant.offer(moved(board, {0.3, 0.0}), name);
    EXPECT_EQ(assistant.input().views.size(), before + (still == Answer::taken ? 1U : 0U));
    if (still == Answer::taken) {
      EXPECT_EQ(assistant.offer(board, name), Answer::nothing_new);
    }
  }
  ASSERT_TRUE(assistant.enough());
  EXPECT_THAT(assistant.missing(), IsEmpty());
  EXPECT_LT(shown, 150U);
  EXPECT_LE(assistant.input().views.size(), 40U);
  const CameraCalibration calibration =
      calibrate_camera(assistant.input(), {.model = LensModel::pinhole_4, .compare_models = false});
  EXPECT_LT(std::abs(calibration.solution.problem.lenses[0].parameters[0] - made.truth.lenses[0].parameters[0]),
            4.0 * calibration.lens_sigmas(0)[0]);
}

TEST(LiveAssistantTest, OneSideAloneIsNeverEnough) {
  const GeneratedBoards made = generate_boards({.seed = 6, .frames = 80, .noise_px = 0.1});
  LiveAssistant assistant({9, 6, 0.025}, 640, 480);
  for (const BoardView& view : made.input.views) {
    const bool right = std::all_of(view.pixels.begin(), view.pixels.end(),
                                   [](const Eigen::Vector2d& pixel) { return pixel.x() > 230.0; });
    if (!right) continue;
    for (int i = 0; i < 2; ++i) assistant.offer(DetectedBoard{view.corners, view.pixels}, "image");
  }
  EXPECT_FALSE(assistant.enough());
  EXPECT_THAT(assistant.missing(), Contains("the whole left side"));
}

}  // namespace
}  // namespace rastro
