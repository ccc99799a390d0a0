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

/// The camera as it was at an earlier frame, but turned about its axis: too far for optical flow and for surfaces from
/// where it was seen last, so that only recognition finds it.
SE3 rolled_back_to(std::int64_t frame, double roll_rad) {
  return PaperedRoom::pose(frame) * SE3(SO3::exp({0.0, 0.0, roll_rad}), Eigen::Vector3d::Zero());
}

TEST(RgbdFollower, KnowsThePlaceAgainAfterTheDark) {
  const PaperedRoom room;
  for (const double roll_rad : {0.0, 0.5}) {
    SCOPED_TRACE(roll_rad);
    RgbdFollower follower({}, room.camera, nullptr);
    for (int i = 0; i < 26; ++i) follower.follow(room.frame(i, PaperedRoom::pose(i)));
    const SE3 last = follower.world_from_camera();
    for (int i = 26; i < 56; ++i) {
      Frame dark;
      dark.index = i;
      dark.stamp = i * (ns_per_second / 30);
      dark.image = GreyImage(room.camera.width, room.camera.height);
      const RgbdFollow follow = follower.follow(dark);
      EXPECT_EQ(follow.state, OdometryState::lost) << i;
      EXPECT_EQ(follow.reason, OdometryReason::dark_or_blank) << i;
    }
    const SE3 seen = rolled_back_to(10, roll_rad);
    const SE3 truth = PaperedRoom::pose(0).inverse() * seen;
    ASSERT_GT((last.inverse() * truth).log().norm(), 0.1) << "staying where it was must not do";
    const RgbdFollow back = follower.follow(room.frame(56, seen));
    EXPECT_EQ(back.state, OdometryState::tracking) << back.detail;
    EXPECT_LT((truth.inverse() * back.world_from_camera).log().norm(), 0.008) << "measured: 0.0055";
    // And it follows on from there.
    const RgbdFollow next = follower.follow(room.frame(57, rolled_back_to(11, roll_rad)));
    EXPECT_EQ(next.state, OdometryState::tracking) << next.detail;
    EXPECT_LT(
        (next.world_from_camera.inverse() * PaperedRoom::pose(0).inverse() * rolled_back_to(11, roll_rad)).log().norm(),
        0.005);
  }
}

TEST(RgbdFollower, APlaceItHasNeverSeenIsNotFound) {
  const PaperedRoom room;
  RgbdFollower follower({}, room.camera, nullptr);
  for (int i = 0; i < 20; ++i) follower.follow(room.frame(i, PaperedRoom::pose(i)));
  const SE3 behind = PaperedRoom::pose(4) * SE3(SO3::exp({0.0, 3.0, 0.0}), Eigen::Vector3d::Zero());
  const RgbdFollow follow = follower.follow(room.frame(20, behind));
  EXPECT_EQ(follow.state, OdometryState::lost) << follow.detail;
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
