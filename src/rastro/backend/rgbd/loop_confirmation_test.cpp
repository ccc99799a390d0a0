// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/loop_confirmation.h"

#include <gtest/gtest.h>

#include <memory>

namespace rastro {
namespace {

/// Keyframes 0 to 9 of submap 0 and 10 to 19 of submap 1, each a meter before the last.
class LoopConfirmationTest : public ::testing::Test {
 protected:
  LoopConfirmationTest() : graph_(RgbdSlamOptions(), 0) {
    for (int k = 0; k < 20; ++k) {
      auto keyframe = std::make_shared<ImageFeatures>();
      keyframe->id = k;
      graph_.add(keyframe, {SE3(SO3(), {0.0, 0.0, k % 10 * 1.0}), k / 10}, Matrix6d::Identity());
    }
  }
  /// That keyframe 10 + k is where k + shift is.
  static LoopHypothesis same_place(int k, double shift_m = 0.0) {
    LoopHypothesis hypothesis;
    hypothesis.edge.from = k, hypothesis.edge.to = 10 + k;
    hypothesis.edge.from_from_to = Sim3(SE3(SO3(), {0.0, 0.0, shift_m}));
    hypothesis.evidence = {0.0, 0.0, 2.0};
    return hypothesis;
  }

  KeyframeGraph graph_;
  LoopConfirmation confirmation_;
};

TEST_F(LoopConfirmationTest, TwoThatRestOnOtherSurfacesConfirmEachOther) {
  EXPECT_TRUE(confirmation_.next(graph_, same_place(1)).empty());
  const auto confirmed = confirmation_.next(graph_, same_place(6, 0.3));
  ASSERT_EQ(confirmed.size(), 2U);
  EXPECT_EQ(confirmed[0].from, 1);
  EXPECT_EQ(confirmed[1].from, 6);
  EXPECT_TRUE(confirmation_.next(graph_, same_place(8)).empty()) << "each counts once";
}

TEST_F(LoopConfirmationTest, TheSameSurfaceTwiceIsOnePieceOfEvidence) {
  LoopHypothesis nearer = same_place(6);
  nearer.evidence.z() = -2.0;
  EXPECT_TRUE(confirmation_.next(graph_, same_place(1)).empty());
  EXPECT_TRUE(confirmation_.next(graph_, nearer).empty());
}

TEST_F(LoopConfirmationTest, OnesThatCorrectTheMapOtherwiseDoNot) {
  EXPECT_TRUE(confirmation_.next(graph_, same_place(1)).empty());
  EXPECT_TRUE(confirmation_.next(graph_, same_place(4, 0.6)).empty());
  EXPECT_EQ(confirmation_.next(graph_, same_place(9, 0.6)).size(), 2U);
}

TEST_F(LoopConfirmationTest, OnesLongAgoDoNot) {
  EXPECT_TRUE(confirmation_.next(graph_, same_place(1)).empty());
  for (int k = 20; k < 50; ++k) {
    auto keyframe = std::make_shared<ImageFeatures>();
    keyframe->id = k;
    graph_.add(keyframe, {SE3(SO3(), {0.0, 0.0, k - 10.0}), 1}, Matrix6d::Identity());
  }
  LoopHypothesis late = same_place(9);
  late.edge.to = 32, late.edge.from_from_to = Sim3(SE3(SO3(), {0.0, 0.0, 13.0}));
  EXPECT_TRUE(confirmation_.next(graph_, late).empty());
}

TEST_F(LoopConfirmationTest, OnesBetweenOtherSubmapsDoNot) {
  LoopHypothesis within = same_place(6);
  within.edge.to = 9;
  EXPECT_TRUE(confirmation_.next(graph_, same_place(1)).empty());
  EXPECT_TRUE(confirmation_.next(graph_, within).empty());
}

}  // namespace
}  // namespace rastro
