// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd/rgbd_odometry.h"

#include <gtest/gtest.h>

#include "rastro/odometry/rgbd_tracking/room_testing.h"

namespace rastro {
namespace {

SE3 first_from(std::int64_t frame) { return PaperedRoom::pose(0).inverse() * PaperedRoom::pose(frame); }

double distance(const SE3& a, const SE3& b) { return (a.translation() - b.translation()).norm(); }

TEST(RgbdOdometry, GivesEveryFrameAPoseInMeters) {
  const PaperedRoom room;
  RgbdOdometry odometry({}, room.camera, nullptr);
  for (int i = 0; i < 15; ++i) odometry.process(room.frame(i, PaperedRoom::pose(i)));
  const Trajectory trajectory = odometry.trajectory();
  ASSERT_EQ(trajectory.size(), 15U);
  for (int i = 0; i < 15; ++i) {
    const StampedPose& pose = trajectory[static_cast<std::size_t>(i)];
    EXPECT_EQ(pose.stamp, i * (ns_per_second / 30));
    EXPECT_LT(distance(pose.world_from_body, first_from(i)), 0.005) << i;
  }
}

/// If the view never returns, the new local map starts at the last pose.
TEST(RgbdOdometry, StartsANewMapAfterASecondOfLoss) {
  const PaperedRoom room;
  RgbdOdometry odometry({}, room.camera, nullptr);
  OdometryUpdate update;
  for (int i = 0; i < 5; ++i) update = odometry.process(room.frame(i, PaperedRoom::pose(i)));
  const SE3 half_rotation(SO3::exp({0.0, 3.0, 0.0}), {0.3, 0.0, 0.0});
  int lost = 0;
  for (int i = 5; i < 60 && (i == 5 || update.state == OdometryState::lost); ++i) {
    update = odometry.process(room.frame(i, PaperedRoom::pose(i) * half_rotation));
    lost += update.state == OdometryState::lost ? 1 : 0;
  }
  EXPECT_EQ(lost, 30) << update.detail;
  EXPECT_NE(update.state, OdometryState::lost);
  const OdometryUpdate next = odometry.process(room.frame(61, PaperedRoom::pose(36) * half_rotation));
  EXPECT_EQ(next.state, OdometryState::tracking) << next.detail;
  EXPECT_LT(distance(update.world_from_camera, next.world_from_camera), 0.05);
}

}  // namespace
}  // namespace rastro
