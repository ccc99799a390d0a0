// SPDX-License-Identifier: Apache-2.0
// A map of one camera begins right or not at all. All twenty starts: rastro_bench_orb_starts.
#include <gtest/gtest.h>

#include "rastro/methods/methods.h"
#include "start_judgement.h"

namespace rastro {
namespace {

StartJudgement judge(StartKind kind, int variation, std::int64_t frames) {
  const auto method = slam_method("orb");
  method->options().set("sensor", "mono", "a test");
  TaskPool pool(2);
  return judge_start(make_start(kind, variation), *method, pool, frames);
}

/// A map that is right to within about one and a half times what was measured.
void expect_right(const StartJudgement& judged, double position, double rotation_rad, double depth) {
  ASSERT_TRUE(judged.started) << judged.waiting;
  EXPECT_TRUE(judged.right());
  EXPECT_LT(judged.position_error, position);
  EXPECT_LT(judged.rotation_error_rad, rotation_rad);
  EXPECT_LT(judged.depth_error, depth);
}

TEST(OrbStarts, AWallIsEnough) {
  const StartJudgement judged = judge(StartKind::planar, 0, 24);
  expect_right(judged, 0.004, 0.004, 0.006);  // measured: 0.0025, 0.0024, 0.0040
  EXPECT_LE(*judged.started, 4);              // 2
  EXPECT_GE(judged.poses, 24U);
  EXPECT_GT(judged.landmarks, 700U);  // 1089
}

TEST(OrbStarts, ATurnOnTheSpotIsNoStart) {
  const StartJudgement judged = judge(StartKind::rotation_first, 0, start_rotation_frames);
  EXPECT_FALSE(judged.started);
  EXPECT_TRUE(judged.never_wrong());
  EXPECT_FALSE(judged.right()) << "no map is not a right one";
  EXPECT_EQ(judged.poses, 0U);
  EXPECT_NE(judged.waiting.find("parallax"), std::string::npos) << judged.waiting;
}

TEST(OrbStarts, BricksThatLookAlikeGiveNoWrongMap) {
  const StartJudgement judged = judge(StartKind::planar, 1, 40);
  ASSERT_TRUE(judged.never_wrong()) << judged.position_error << ' ' << judged.depth_error;
  if (judged.started) expect_right(judged, 0.010, 0.012, 0.015);  // 0.0067, 0.0079, 0.0098
}

TEST(OrbStarts, WhatProvesWrongBeginsAnew) {
  const StartJudgement judged = judge(StartKind::near, 3, start_frames);
  expect_right(judged, 0.0045, 0.017, 0.018);  // 0.0028, 0.0112, 0.0121
  EXPECT_GE(judged.poses, 58U);
}

/// Or the limits above would say nothing: a map as it would be at a wrong depth, and a camera that went another way.
TEST(OrbStarts, AWrongMapIsJudgedWrong) {
  StartJudgement judged;
  judged.started = 3;
  judged.landmarks = 500;
  EXPECT_TRUE(judged.right());
  for (double StartJudgement::*error :
       {&StartJudgement::position_error, &StartJudgement::rotation_error_rad, &StartJudgement::depth_error}) {
    StartJudgement wrong = judged;
    wrong.*error = 0.2;
    EXPECT_FALSE(wrong.right());
    EXPECT_FALSE(wrong.never_wrong());
  }
  judged.landmarks = 3;
  EXPECT_FALSE(judged.right());
}

}  // namespace
}  // namespace rastro
