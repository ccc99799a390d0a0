// SPDX-License-Identifier: Apache-2.0
// Tracking lost, relocalized, or in another submap.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/wall_run_testing.h"

namespace rastro {
namespace {

using testing::count_of;
using testing::pose_near;
using testing::WallRun;

TEST(Tracking, LostFramesExtrapolateTheMotionAndAreRelocalized) {
  WallRun run;
  for (int k = 0; k < 3; ++k) run.process(k, 0.02 * k);
  Frame elsewhere = run.frame_at(3, SE3(SO3(), {40.0, 30.0, 0.0}));
  const SlamUpdate lost = run.process(elsewhere);
  EXPECT_EQ(lost.state, SlamState::lost);
  EXPECT_EQ(lost.reason, SlamReason::few_inliers);
  EXPECT_THAT(lost.detail, ::testing::MatchesRegex("needs at least 30 inliers, got [0-9]+ of [0-9]+ matches"));
  EXPECT_THAT(lost.world_from_body, pose_near(run.beside(0.06), 0.02, 0.006));
  EXPECT_FALSE(run.session.tracking);
  EXPECT_EQ(run.session.lost_frames, 1);
  elsewhere = run.frame_at(4, SE3(SO3(), {42.0, 30.0, 0.0}));
  const SlamUpdate still = run.process(elsewhere);
  EXPECT_EQ(still.reason, SlamReason::not_found);
  EXPECT_EQ(run.session.lost_frames, 2);
  EXPECT_EQ(count_of(run.tracking.observations(), ObservationState::inlier), 0U);
  // Far from where the motion was leading.
  for (const int k : {5, 6}) {
    const SlamUpdate unconfirmed = run.process(k, 0.01 * k - 0.3);
    EXPECT_EQ(unconfirmed.state, SlamState::lost);
    EXPECT_EQ(unconfirmed.reason, SlamReason::unconfirmed);
    EXPECT_FALSE(unconfirmed.covariance);
    EXPECT_EQ(count_of(run.tracking.observations(), ObservationState::inlier), 0U);
    EXPECT_EQ(run.session.trajectory.frames().size(), 3U);
  }
  const SlamUpdate found = run.process(7, -0.23);
  EXPECT_EQ(found.state, SlamState::relocalized);
  EXPECT_TRUE(run.session.tracking);
  EXPECT_THAT(found.world_from_body, pose_near(run.beside(-0.23), 0.01, 0.003));
  EXPECT_EQ(run.session.trajectory.frames().size(), 6U) << "the unconfirmed ones have poses too now";
  EXPECT_EQ(run.process(8, -0.22).state, SlamState::tracking);
}

/// Relocalized again and again, but never believed.
TEST(Tracking, ASubmapBeginsWhereAPlaceThatOnlyLooksAlikeIsRejected) {
  OrbSlamOptions options = WallRun::wall_options();
  options.lost_frames = 3;
  options.relocalize_frames = 1;
  options.relocalize_chance_ratio = 10000.0;
  WallRun run(options);
  for (int k = 0; k < 3; ++k) run.process(k, 0.02 * k);
  run.process(run.frame_at(3, SE3(SO3(), {40.0, 30.0, 0.0})));
  const SlamUpdate lost = run.process(4, -0.25);
  EXPECT_EQ(lost.state, SlamState::lost);
  EXPECT_EQ(lost.reason, SlamReason::not_found);
  EXPECT_THAT(lost.detail, ::testing::HasSubstr("visible landmarks fit")) << "the hypothesis was judged";
  EXPECT_EQ(run.session.graph.submap_count(), 1);
  const SlamUpdate begun = run.process(5, -0.24);
  EXPECT_EQ(run.session.graph.submap_count(), 2);
  EXPECT_EQ(begun.state, SlamState::weak);
  EXPECT_EQ(begun.reason, SlamReason::apart);
  EXPECT_TRUE(run.session.tracking);
}

TEST(Tracking, ADisconnectedSubmapIsReported) {
  OrbSlamOptions options = WallRun::wall_options();
  options.lost_frames = 2;
  WallRun run(options);
  run.process(0, 0.0);
  SlamUpdate update;
  for (int k = 1; k < 4; ++k) update = run.process(run.frame_at(k, SE3(SO3(), {40.0 + 0.01 * k, 30.0, 0.0})));
  EXPECT_EQ(run.session.graph.submap_count(), 2);
  EXPECT_EQ(update.state, SlamState::weak);
  EXPECT_EQ(update.reason, SlamReason::apart);
  EXPECT_EQ(update.detail, "in submap 1, not connected to the first yet");
}

}  // namespace
}  // namespace rastro
