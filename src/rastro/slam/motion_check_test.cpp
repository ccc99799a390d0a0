// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/motion_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace rastro {
namespace {

constexpr TimeNs interval = 50'000'000;  // 20 Hz: a step of 1 cm more than the last one is 4 m/s^2

SlamUpdate update_at(std::int64_t index, double x, SlamState state = SlamState::tracking) {
  SlamUpdate update;
  update.index = index;
  update.stamp = index * interval;
  update.state = state;
  update.world_from_body = SE3(SO3(), {x, 0.0, 0.0});
  return update;
}

SlamUpdate checked(MotionCheck& check, SlamUpdate update) {
  if (corrects_map(update.events)) check.forget();
  check.check(update);
  return update;
}

TEST(MotionCheck, ConstantVelocityIsPlausibleAtAnySpeed) {
  MotionCheck check(1.0);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(checked(check, update_at(i, 3.0 * i)).state, SlamState::tracking);
}

TEST(MotionCheck, AStepIsWeakAboveTheLimitOnly) {
  for (const double step : {0.036, 0.039}) {
    MotionCheck check(15.0);  // 0.0375 m at 20 Hz
    for (int i = 0; i < 3; ++i) checked(check, update_at(i, 0.0));
    const SlamUpdate moved = checked(check, update_at(3, step));
    EXPECT_EQ(moved.state, step > 0.0375 ? SlamState::weak : SlamState::tracking);
    EXPECT_EQ(moved.reason, step > 0.0375 ? SlamReason::implausible_motion : SlamReason::none);
    EXPECT_EQ(moved.detail.empty(), step < 0.0375);
  }
}

TEST(MotionCheck, BothEdgesOfASpikeAreWeak) {
  MotionCheck check(15.0);
  const double x[] = {0.0, 0.0, 0.05, 0.0, 0.0, 0.0};
  const SlamState states[] = {SlamState::tracking, SlamState::tracking, SlamState::weak,
                              SlamState::weak,     SlamState::weak,     SlamState::tracking};
  for (int i = 0; i < 6; ++i) EXPECT_EQ(checked(check, update_at(i, x[i])).state, states[i]) << i;
}

TEST(MotionCheck, ZeroChecksNothing) {
  MotionCheck check(0.0);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(checked(check, update_at(i, i % 2)).state, SlamState::tracking);
}

TEST(MotionCheck, WeakAndLostKeepTheirReason) {
  for (const SlamState state : {SlamState::weak, SlamState::lost, SlamState::relocalized}) {
    MotionCheck check(15.0);
    for (int i = 0; i < 3; ++i) checked(check, update_at(i, 0.0));
    SlamUpdate moved = update_at(3, 1.0, state);
    moved.reason = SlamReason::few_inliers;
    moved = checked(check, moved);
    EXPECT_EQ(moved.state, state);
    EXPECT_EQ(moved.reason, SlamReason::few_inliers);
  }
}

TEST(MotionCheck, BeginsAnewAfterALossAGapAndACorrectionOfTheMap) {
  for (const SlamState state : {SlamState::initializing, SlamState::lost, SlamState::relocalized}) {
    MotionCheck check(15.0);
    for (int i = 0; i < 3; ++i) checked(check, update_at(i, 0.0));
    checked(check, update_at(3, 1.0, state));
    EXPECT_EQ(checked(check, update_at(4, 2.0)).state, SlamState::tracking);
    EXPECT_EQ(checked(check, update_at(5, 3.0)).state, SlamState::tracking);
    EXPECT_EQ(checked(check, update_at(6, 3.0)).state, SlamState::weak);
  }
  MotionCheck gap(15.0);
  for (int i = 0; i < 3; ++i) checked(gap, update_at(i, 0.0));
  EXPECT_EQ(checked(gap, update_at(13, 9.0)).state, SlamState::tracking);
  for (const char* kind : {"loop_closed", "joined", "map_revised", "keyframe"}) {
    MotionCheck check(15.0);
    for (int i = 0; i < 3; ++i) checked(check, update_at(i, 0.0));
    SlamUpdate corrected = update_at(3, 1.0);
    corrected.events.push_back({kind, ""});
    const bool counts = std::string(kind) == "keyframe";
    EXPECT_EQ(checked(check, corrected).state, counts ? SlamState::weak : SlamState::tracking) << kind;
    EXPECT_EQ(checked(check, update_at(4, 1.0)).state, counts ? SlamState::weak : SlamState::tracking) << kind;
  }
}

/// By half a turn to the left: what went ahead goes back.
TEST(MotionCheck, AKnownCorrectionOfTheMapIsNoMotion) {
  const SE3 correction(SO3::exp({0.0, 0.0, M_PI}), {3.0, 0.0, 0.0});
  for (const bool is_known : {true, false}) {
    MotionCheck check(15.0);
    for (int i = 0; i < 3; ++i) checked(check, update_at(i, 0.1 * i));
    if (is_known) check.follow(correction);
    EXPECT_EQ(checked(check, update_at(3, 3.0 - 0.3)).state, is_known ? SlamState::tracking : SlamState::weak);
  }
  MotionCheck check(15.0);
  for (int i = 0; i < 3; ++i) checked(check, update_at(i, 0.1 * i));
  check.follow(correction);
  EXPECT_EQ(checked(check, update_at(3, 3.0 - 0.35)).state, SlamState::weak) << "a jump in the same frame shows";
}

}  // namespace
}  // namespace rastro
