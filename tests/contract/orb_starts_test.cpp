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

TEST(OrbStarts, AWallIsEnough) {
  const StartJudgement judged = judge(StartKind::planar, 0, 24);
  EXPECT_TRUE(judged.started);
  EXPECT_TRUE(judged.right()) << judged.position_error << ' ' << judged.depth_error;
}

TEST(OrbStarts, ATurnOnTheSpotIsNoStart) {
  const StartJudgement judged = judge(StartKind::rotation_first, 0, start_rotation_frames);
  EXPECT_FALSE(judged.started);
  EXPECT_FALSE(judged.waiting.empty());
}

TEST(OrbStarts, BricksThatLookAlikeGiveNoWrongMap) {
  const StartJudgement judged = judge(StartKind::planar, 1, 40);
  EXPECT_TRUE(judged.right()) << *judged.started << ' ' << judged.position_error << ' ' << judged.depth_error;
}

TEST(OrbStarts, WhatProvesWrongBeginsAnew) {
  const StartJudgement judged = judge(StartKind::near, 3, start_frames);
  EXPECT_TRUE(judged.started);
  EXPECT_TRUE(judged.right()) << judged.position_error << ' ' << judged.depth_error;
}

}  // namespace
}  // namespace rastro
