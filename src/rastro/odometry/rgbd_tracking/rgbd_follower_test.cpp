// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/rgbd_follower.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "rastro/odometry/rgbd_tracking/room_testing.h"

namespace rastro {
namespace {

double way_off(const SE3& world_from_camera, std::int64_t frame) {
  const SE3 truth = PaperedRoom::pose(0).inverse() * PaperedRoom::pose(frame);
  return (truth.translation() - world_from_camera.translation()).norm();
}

TEST(RgbdFollower, FollowsAKnownWayAndTheSameForAnyPool) {
  const PaperedRoom room;
  TaskPool pool(3);
  RgbdFollower alone({}, room.camera, nullptr), shared({}, room.camera, &pool);
  for (int i = 0; i < 30; ++i) {
    const Frame frame = room.frame(i, PaperedRoom::pose(i));
    const RgbdFollow a = alone.follow(frame), b = shared.follow(frame);
    EXPECT_EQ(a.state, OdometryState::tracking) << i << " " << a.detail;
    EXPECT_LT(way_off(a.world_from_camera, i), 0.005) << i;
    EXPECT_EQ(a.world_from_camera.matrix(), b.world_from_camera.matrix());
  }
}

TEST(RgbdFollower, SurfacesCarryBareWalls) {
  PaperedRoom room;
  room.papered = false;
  RgbdOptions options;
  options.frame_check.min_deviation = 0.0;
  options.frame_check.max_repeat_difference = 0.0;
  RgbdFollower follower(options, room.camera, nullptr);
  for (int i = 0; i < 20; ++i) {
    Frame frame = room.frame(i, PaperedRoom::pose(i));
    frame.image.at(0, 0) = static_cast<std::uint8_t>(10 * i);  // or it would be the same image once more
    const RgbdFollow follow = follower.follow(frame);
    EXPECT_EQ(follow.state, OdometryState::tracking) << i << " " << follow.detail;
    EXPECT_LT(way_off(follow.world_from_camera, i), 0.01) << i;
    EXPECT_LT(follow.texture_share, 0.01);
  }
}

TEST(RgbdFollower, KnowsThePlaceAgainAfterTheDark) {
  const PaperedRoom room;
  RgbdFollower follower({}, room.camera, nullptr);
  for (int i = 0; i < 10; ++i) follower.follow(room.frame(i, PaperedRoom::pose(i)));
  for (int i = 10; i < 40; ++i) {
    Frame dark = room.frame(i, PaperedRoom::pose(i));
    dark.image = GreyImage(room.camera.width, room.camera.height);
    dark.depth = {};
    const RgbdFollow follow = follower.follow(dark);
    EXPECT_NE(follow.state, OdometryState::tracking);
    EXPECT_EQ(follow.reason, i == 10 ? OdometryReason::dark_or_blank : follow.reason);
  }
  const RgbdFollow back = follower.follow(room.frame(40, PaperedRoom::pose(12)));
  EXPECT_EQ(back.state, OdometryState::tracking) << back.detail;
  EXPECT_LT(way_off(back.world_from_camera, 12), 0.01);
}

TEST(RgbdFollower, EmptyAndRepeatedFramesAndAMaskOverAllAreNoFault) {
  const PaperedRoom room;
  RgbdFollower follower({}, room.camera, nullptr);
  EXPECT_EQ(follower.follow({}).state, OdometryState::initialising);
  follower.follow(room.frame(1, PaperedRoom::pose(1)));
  EXPECT_EQ(follower.follow(room.frame(1, PaperedRoom::pose(1))).reason, OdometryReason::repeated_frame);
  RgbdFollower masked({}, room.camera, nullptr);
  for (int i = 0; i < 3; ++i) {
    Frame frame = room.frame(i, PaperedRoom::pose(i));
    frame.mask = GreyImage(room.camera.width, room.camera.height);
    const RgbdFollow follow = masked.follow(frame);
    EXPECT_EQ(follow.points, 0);
    EXPECT_EQ(follow.surface_points, 0);
  }
}

}  // namespace
}  // namespace rastro
