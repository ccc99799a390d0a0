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

  std::vector<Constraint> next(const LoopHypothesis& hypothesis, bool still_fits = true) {
    return confirmation_.next(graph_, hypothesis, [still_fits](const Constraint&) { return still_fits; });
  }

  KeyframeGraph graph_;
  LoopConfirmation confirmation_;
};

TEST_F(LoopConfirmationTest, TwoThatRestOnOtherSurfacesConfirmEachOther) {
  EXPECT_TRUE(next(same_place(1)).empty());
  const auto confirmed = next(same_place(6, 0.3));
  ASSERT_EQ(confirmed.size(), 2U);
  EXPECT_EQ(confirmed[0].from, 1);
  EXPECT_EQ(confirmed[1].from, 6);
  EXPECT_TRUE(next(same_place(8)).empty()) << "each counts once";
}

TEST_F(LoopConfirmationTest, TheSameSurfaceTwiceIsOnePieceOfEvidence) {
  LoopHypothesis nearer = same_place(6);
  nearer.evidence.z() = -2.0;
  EXPECT_TRUE(next(same_place(1)).empty());
  EXPECT_TRUE(next(nearer).empty());
}

TEST_F(LoopConfirmationTest, OnesThatCorrectTheMapOtherwiseDoNot) {
  EXPECT_TRUE(next(same_place(1)).empty());
  EXPECT_TRUE(next(same_place(4, 0.6)).empty());
  EXPECT_EQ(next(same_place(9, 0.6)).size(), 2U);
}

/// Turned by 0.09 rad about keyframe 19: where the other was found, 8 m away, that is 0.72 m.
TEST_F(LoopConfirmationTest, OnesThatCorrectTheMapAlikeAtOneOfTheTwoPlacesDoNot) {
  const Eigen::Vector3d center(0.0, 0.0, 9.0);
  const SO3 turned = SO3::exp({0.09, 0.0, 0.0});
  const SE3 correction(turned, center - turned * center);
  LoopHypothesis first = same_place(1);
  first.edge.from_from_to = Sim3(graph_.pose(1).inverse() * correction * graph_.pose(11));
  EXPECT_TRUE(next(first).empty());
  EXPECT_TRUE(next(same_place(9)).empty());
}

TEST_F(LoopConfirmationTest, TwoOfOneKeyframeDoNot) {
  LoopHypothesis second = same_place(1);
  second.edge.from = 2;
  second.edge.from_from_to = Sim3(graph_.pose(2).inverse() * graph_.pose(11));
  second.evidence.z() = 8.0;
  EXPECT_TRUE(next(same_place(1)).empty());
  EXPECT_TRUE(next(second).empty());
  EXPECT_EQ(next(same_place(9)).size(), 2U) << "with the first; the second rests on the same surfaces";
}

/// Another loop may have been closed in between.
TEST_F(LoopConfirmationTest, OneThatTheMapContradictsByNowIsDropped) {
  EXPECT_TRUE(next(same_place(1)).empty());
  EXPECT_TRUE(next(same_place(6), false).empty());
  const auto confirmed = next(same_place(9, 0.3));
  EXPECT_TRUE(confirmed.empty()) << "it waits no longer";
}

TEST_F(LoopConfirmationTest, OnesLongAgoDoNot) {
  EXPECT_TRUE(next(same_place(1)).empty());
  for (int k = 20; k < 50; ++k) {
    auto keyframe = std::make_shared<ImageFeatures>();
    keyframe->id = k;
    graph_.add(keyframe, {SE3(SO3(), {0.0, 0.0, k - 10.0}), 1}, Matrix6d::Identity());
  }
  LoopHypothesis late = same_place(9);
  late.edge.to = 32, late.edge.from_from_to = Sim3(SE3(SO3(), {0.0, 0.0, 13.0}));
  EXPECT_TRUE(next(late).empty());
}

TEST(AgreesWithMap, UpToThreeTenthsOfAMeterAndATenthOfARadian) {
  const SE3 predicted(SO3::exp({0.0, 1.0, 0.5}), {3.0, -2.0, 7.0});
  const auto agrees = [&](double off_m, double off_rad) {
    return agrees_with_map(predicted, predicted * SE3(SO3::exp({0.0, off_rad, 0.0}), {off_m, 0.0, 0.0}));
  };
  EXPECT_TRUE(agrees(0.29, 0.09));
  EXPECT_FALSE(agrees(0.31, 0.0));
  EXPECT_FALSE(agrees(0.0, 0.11));
}

TEST_F(LoopConfirmationTest, OnesBetweenOtherSubmapsDoNot) {
  LoopHypothesis within = same_place(6);
  within.edge.to = 9;
  EXPECT_TRUE(next(same_place(1)).empty());
  EXPECT_TRUE(next(within).empty());
}

}  // namespace
}  // namespace rastro
