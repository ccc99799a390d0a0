// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/live_assistant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/calibration/boards_testing.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::ElementsAre;
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
  EXPECT_EQ(assistant.offer({}, "0"), Answer::no_board);
  std::size_t shown = 0;
  for (const BoardView& view : made.input.views) {
    if (assistant.enough()) break;
    const DetectedBoard board{view.corners, view.pixels};
    const std::string name = std::to_string(shown++);
    EXPECT_EQ(assistant.offer({moved(board, {40.0, 0.0}), std::nullopt}, name), Answer::moving) << "from elsewhere";
    EXPECT_EQ(assistant.offer({moved(board, {8.0, 0.0}), std::nullopt}, name), Answer::moving)
        << "by 32 pixels an image";
    EXPECT_EQ(assistant.offer({board, std::nullopt}, name), Answer::moving) << "by 8 pixels an image";
    const std::size_t before = assistant.input().views.size();
    const Answer still = assistant.offer({moved(board, {0.3, 0.0}), std::nullopt}, name);
    EXPECT_EQ(assistant.input().views.size(), before + (still == Answer::taken ? 1U : 0U));
    if (still == Answer::taken) {
      EXPECT_EQ(assistant.offer({board, std::nullopt}, name), Answer::nothing_new);
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
    for (int i = 0; i < 2; ++i) assistant.offer({DetectedBoard{view.corners, view.pixels}, std::nullopt}, "image");
  }
  EXPECT_FALSE(assistant.enough());
  EXPECT_THAT(assistant.missing(), Contains("the whole left side"));
}

FoundBoards pair_of(const GeneratedBoards& made, std::size_t frame) {
  FoundBoards found;
  for (const BoardView& view : made.input.views)
    if (view.frame == static_cast<int>(frame))
      found[static_cast<std::size_t>(view.camera)] = DetectedBoard{view.corners, view.pixels};
  return found;
}

/// Shown twice, so that it is held still.
Answer show(LiveAssistant& assistant, const FoundBoards& found) {
  assistant.offer(found, "image");
  return assistant.offer(found, "image");
}

TEST(LiveAssistantTest, AViewOfAnEdgeThatAloneIsMissingIsTakenAlsoWithEnoughViews) {
  const GeneratedBoards made = generate_boards({.seed = 7, .frames = 200, .noise_px = 0.1});
  LiveAssistant assistant({9, 6, 0.025}, 640, 480);
  const double outer_sixth = made.input.width / 6.0;
  const auto at_edge = [&](std::size_t frame) {
    const std::vector<Eigen::Vector2d>& pixels = made.input.views[frame].pixels;
    return std::any_of(pixels.begin(), pixels.end(),
                       [&](const Eigen::Vector2d& pixel) { return pixel.x() < outer_sixth; });
  };
  for (std::size_t k = 0; k < made.input.frames.size(); ++k)
    if (!at_edge(k)) show(assistant, pair_of(made, k));
  ASSERT_GE(assistant.views(), assistant.enough_views());
  ASSERT_THAT(assistant.missing(), ElementsAre("the left edge"));
  for (std::size_t k = 0; k < made.input.frames.size() && !assistant.enough(); ++k)
    if (at_edge(k)) show(assistant, pair_of(made, k));
  EXPECT_TRUE(assistant.enough());
  EXPECT_THAT(assistant.missing(), IsEmpty());
}

TEST(LiveAssistantTest, OfAPairBothCamerasLackNothing) {
  const GeneratedBoards made = generate_boards({.seed = 8, .frames = 200, .noise_px = 0.1, .stereo = true});
  LiveAssistant assistant({9, 6, 0.025}, 640, 480, {.stereo = true});
  EXPECT_THAT(assistant.missing(), Contains("the whole image")) << "named once for both";
  for (std::size_t k = 0; k < made.input.frames.size() && !assistant.enough(); ++k) show(assistant, pair_of(made, k));
  ASSERT_TRUE(assistant.enough());
  EXPECT_GE(assistant.views(), 20);
  EXPECT_THAT(assistant.coverage(0).missing, IsEmpty());
  EXPECT_THAT(assistant.coverage(1).missing, IsEmpty());
  const CameraCalibration calibration =
      calibrate_camera(assistant.input(), {.model = LensModel::pinhole_4, .compare_models = false});
  const SE3 off = calibration.solution.problem.right_from_left * made.truth.right_from_left.inverse();
  EXPECT_LT(off.translation().norm(), 0.0002) << "of 0.06 m";
}

TEST(LiveAssistantTest, ABoardThatOneCameraSeesIsTakenOnlyForWhatThatCameraLacks) {
  const GeneratedBoards made = generate_boards({.seed = 8, .frames = 40, .noise_px = 0.1, .stereo = true});
  LiveAssistant assistant({9, 6, 0.025}, 640, 480, {.enough_views = 3, .stereo = true});
  for (std::size_t k = 0; k < 20; ++k) {
    FoundBoards left = pair_of(made, k);
    left[1] = std::nullopt;
    show(assistant, left);
  }
  EXPECT_EQ(assistant.views(), 0);
  EXPECT_FALSE(assistant.enough());
  EXPECT_THAT(assistant.missing(), Contains("right camera: the whole image"));
  int one_camera = 0;
  for (std::size_t k = 20; k < 40; ++k) {
    FoundBoards left = pair_of(made, k);
    left[1] = std::nullopt;
    one_camera += show(assistant, left) == Answer::one_camera ? 1 : 0;
  }
  EXPECT_GE(one_camera, 10);
  EXPECT_LE(assistant.input().frames.size(), 12U) << "nothing is taken twice";
}

TEST(LiveAssistantTest, DepthNeedsBoardsAtTwiceTheDistance) {
  const GeneratedBoards made = generate_boards({.seed = 5, .frames = 150, .noise_px = 0.1});
  LiveAssistant near({9, 6, 0.025}, 640, 480, {.distances = true}), plain({9, 6, 0.025}, 640, 480);
  for (std::size_t k = 0; k < made.input.frames.size(); ++k) {
    if (made.truth.left_from_board[k].translation().norm() > 0.42) continue;
    show(near, pair_of(made, k));
    show(plain, pair_of(made, k));
  }
  EXPECT_THAT(plain.missing(), IsEmpty());
  EXPECT_THAT(near.missing(), ElementsAre("boards at twice the distance"));
  EXPECT_FALSE(near.enough());
}

}  // namespace
}  // namespace rastro
