// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_errors.h"

#include <gtest/gtest.h>

#include <numbers>

#include "rastro/base/error.h"
#include "rastro/math/se3.h"

namespace rastro {
namespace {

/// Straight along x: pose k at k meters and k times 0.1 s; the estimate's steps are longer by `scale`.
PairedPoses straight(int count, double scale) {
  PairedPoses poses;
  for (int k = 0; k < count; ++k) {
    poses.reference.push_back(SE3(SO3(), {1.0 * k, 0, 0}).matrix());
    poses.estimate.push_back(SE3(SO3(), {scale * k, 0, 0}).matrix());
    poses.stamps.push_back(TimeNs(k) * 100'000'000);
  }
  return poses;
}

TEST(TrajectoryErrors, StatisticsOfKnownNumbers) {
  const auto odd = statistics_of({3.0, 0.0, 4.0});
  ASSERT_TRUE(odd);
  EXPECT_DOUBLE_EQ(odd->rmse, std::sqrt(25.0 / 3.0));
  EXPECT_DOUBLE_EQ(odd->mean, 7.0 / 3.0);
  EXPECT_EQ(odd->median, 3.0);
  EXPECT_EQ(odd->max, 4.0);
  EXPECT_EQ(odd->min, 0.0);
  EXPECT_EQ(statistics_of({4.0, 1.0, 2.0, 9.0})->median, 3.0);
  EXPECT_FALSE(statistics_of({}));
}

TEST(TrajectoryErrors, RelativeErrorIsTheResidualMotion) {
  PairedPoses poses = straight(2, 1.0);
  poses.estimate[1] = SE3(SO3::exp({0, 0, 0.25}), {1.0, 0.3, 0.4}).matrix();
  const auto error = relative_error(poses, 0, 1);
  EXPECT_NEAR(error.translation_m, 0.5, 1e-12);
  EXPECT_NEAR(error.rotation_rad, 0.25, 1e-12);
}

TEST(TrajectoryErrors, RelativeErrorsDoNotDependOnARigidMotionOfTheWorld) {
  PairedPoses poses = straight(30, 1.1);
  const auto before = relative_errors(poses, {5.0, RpeDelta::Unit::frames}, true);
  const SE3 moved(SO3::exp({0.3, -1.0, 2.0}), {100, -20, 3});
  for (auto& pose : poses.estimate) pose = (moved.matrix() * pose).eval();
  const auto after = relative_errors(poses, {5.0, RpeDelta::Unit::frames}, true);
  ASSERT_EQ(before.size(), 25u);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_NEAR(before[k].translation_m, 0.5, 1e-12);
    EXPECT_NEAR(after[k].translation_m, 0.5, 1e-10);
    EXPECT_NEAR(after[k].rotation_rad, 0.0, 1e-7);
  }
}

TEST(TrajectoryErrors, ConsecutivePairsFollowEachOther) {
  const PairedPoses poses = straight(21, 1.1);
  // 20 steps in frames, 4 chains of 5.
  EXPECT_EQ(relative_errors(poses, {1.0, RpeDelta::Unit::frames}, false).size(), 20u);
  EXPECT_EQ(relative_errors(poses, {5.0, RpeDelta::Unit::frames}, false).size(), 4u);
  // 2 s in all, 0.5 s each.
  const auto seconds = relative_errors(poses, {0.5, RpeDelta::Unit::seconds}, false);
  ASSERT_EQ(seconds.size(), 4u);
  EXPECT_NEAR(seconds[0].translation_m, 0.5, 1e-12);
  EXPECT_EQ(relative_errors(poses, {0.5, RpeDelta::Unit::seconds}, true).size(), 16u);
}

TEST(TrajectoryErrors, MetersAreOfTheEstimateAndBeginAfterTheFirstDelta) {
  const PairedPoses poses = straight(21, 2.0);  // 40 m long, every 10 m a pose
  const auto errors = relative_errors(poses, {10.0, RpeDelta::Unit::meters}, false);
  ASSERT_EQ(errors.size(), 3u);
  for (const auto& error : errors) EXPECT_NEAR(error.translation_m, 5.0, 1e-12);
  EXPECT_EQ(relative_errors(poses, {10.0, RpeDelta::Unit::meters}, true).size(), 16u);
}

TEST(TrajectoryErrors, TooFewPosesOrNoStampsGiveNoErrors) {
  const PairedPoses none, one = straight(1, 1.0);
  for (const auto unit : {RpeDelta::Unit::frames, RpeDelta::Unit::seconds, RpeDelta::Unit::meters})
    for (const bool all : {false, true}) {
      EXPECT_TRUE(relative_errors(none, {1.0, unit}, all).empty());
      EXPECT_TRUE(relative_errors(one, {1.0, unit}, all).empty());
    }
  PairedPoses unstamped = straight(5, 1.0);
  unstamped.stamps.clear();
  EXPECT_TRUE(relative_errors(unstamped, {0.1, RpeDelta::Unit::seconds}, false).empty());
  EXPECT_EQ(segment_errors(none, {100.0}).front().count, 0);
}

TEST(TrajectoryErrors, SegmentsOfAScaledPath) {
  // 201 m: segments of 100 m begin at 0, 10, ... and end one pose beyond the length, at 101 m.
  const auto segments = segment_errors(straight(202, 1.02), {100.0, 300.0});
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_EQ(segments[0].count, 11);
  EXPECT_NEAR(segments[0].translation_percent, 2.0 * 1.01, 1e-9);
  EXPECT_NEAR(segments[0].rotation_deg_per_m, 0.0, 1e-7);
  EXPECT_EQ(segments[1].count, 0);
}

TEST(TrajectoryErrors, SegmentsOfARotatingEstimate) {
  PairedPoses poses = straight(60, 1.0);
  for (int k = 0; k < 60; ++k)
    poses.estimate[static_cast<std::size_t>(k)] = SE3(SO3::exp({0, 0.01 * k, 0}), {1.0 * k, 0, 0}).matrix();
  const auto segments = segment_errors(poses, {20.0});
  EXPECT_EQ(segments[0].count, 4);
  EXPECT_NEAR(segments[0].rotation_deg_per_m, 0.21 * 180.0 / std::numbers::pi / 20.0, 1e-9);
}

TEST(TrajectoryErrors, DeltasAreParsed) {
  EXPECT_EQ(parse_rpe_delta("10m").unit, RpeDelta::Unit::meters);
  EXPECT_EQ(parse_rpe_delta(" 0.5s").value, 0.5);
  EXPECT_EQ(as_text(parse_rpe_delta("3f")), "3f");
  EXPECT_EQ(as_text(parse_rpe_delta("10m")), "10m");
  for (const char* wrong : {"", "m", "10", "1.5f", "0m", "-1s", "nans", "infm", "1km"})
    EXPECT_THROW(parse_rpe_delta(wrong), Error) << wrong;
}

}  // namespace
}  // namespace rastro
