// SPDX-License-Identifier: Apache-2.0
// Initialization with one camera is correct or does not happen. All twenty sequences: rastro_bench_orb_starts.
#include <gtest/gtest.h>

#include "rastro/methods/methods.h"
#include "start_judgment.h"

namespace rastro {
namespace {

StartJudgment judge(StartKind kind, int variation, std::int64_t frames) {
  const auto method = slam_method("orb");
  method->options().set("sensor", "mono", "a test");
  TaskPool pool(2);
  return judge_start(make_start(kind, variation), *method, pool, frames);
}

/// Limits of a correct map: about 1.5 times the measured errors.
void expect_right(const StartJudgment& judged, double position, double rotation_rad, double depth) {
  ASSERT_TRUE(judged.started) << judged.waiting;
  EXPECT_TRUE(judged.right());
  EXPECT_LT(judged.position_error, position);
  EXPECT_LT(judged.rotation_error_rad, rotation_rad);
  EXPECT_LT(judged.depth_error, depth);
}

TEST(OrbStarts, AWallIsEnough) {
  const StartJudgment judged = judge(StartKind::planar, 0, 24);
  expect_right(judged, 0.004, 0.004, 0.006);  // measured: 0.0025, 0.0024, 0.0040
  EXPECT_LE(*judged.started, 4);              // 2
  EXPECT_GE(judged.poses, 24U);
  EXPECT_GT(judged.landmarks, 700U);  // 1089
}

TEST(OrbStarts, ARotationOnTheSpotDoesNotInitialize) {
  const StartJudgment judged = judge(StartKind::rotation_first, 0, start_rotation_frames);
  EXPECT_FALSE(judged.started);
  EXPECT_TRUE(judged.never_wrong());
  EXPECT_FALSE(judged.right()) << "no map is not a right one";
  EXPECT_EQ(judged.poses, 0U);
  EXPECT_NE(judged.waiting.find("parallax"), std::string::npos) << judged.waiting;
}

TEST(OrbStarts, BricksThatLookAlikeGiveNoWrongMap) {
  const StartJudgment judged = judge(StartKind::planar, 1, 40);
  ASSERT_TRUE(judged.never_wrong()) << judged.position_error << ' ' << judged.depth_error;
  if (judged.started) expect_right(judged, 0.010, 0.012, 0.015);  // 0.0067, 0.0079, 0.0098
}

TEST(OrbStarts, WhatProvesWrongBeginsAnew) {
  const StartJudgment judged = judge(StartKind::near, 3, start_frames);
  expect_right(judged, 0.0045, 0.017, 0.018);  // 0.0028, 0.0112, 0.0121
  EXPECT_GE(judged.poses, 58U);
}

/// The limits are meaningful: a map at a wrong depth and another trajectory fail them.
TEST(OrbStarts, AWrongMapIsJudgedWrong) {
  StartJudgment judged;
  judged.started = 3;
  judged.landmarks = 500;
  EXPECT_TRUE(judged.right());
  for (double StartJudgment::*error :
       {&StartJudgment::position_error, &StartJudgment::rotation_error_rad, &StartJudgment::depth_error}) {
    StartJudgment wrong = judged;
    wrong.*error = 0.2;
    EXPECT_FALSE(wrong.right());
    EXPECT_FALSE(wrong.never_wrong());
  }
  judged.landmarks = 3;
  EXPECT_FALSE(judged.right());
}

}  // namespace
}  // namespace rastro
