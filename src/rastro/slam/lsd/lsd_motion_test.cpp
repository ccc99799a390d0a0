// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_motion.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

SE3 some_pose(double scale) { return SE3::exp((Vector6d() << 0.3, -0.2, 0.1, 0.2, 0.1, -0.3).finished() * scale); }

/// A point of the new keyframe is where it was, in the new unit.
TEST(LsdMotion, ANewKeyframeChangesTheUnitAndNotThePlace) {
  const Sim3 before_from_new = Sim3(some_pose(1.0)) * Sim3(2.5, SO3(), Eigen::Vector3d::Zero());
  const SE3 camera_from_before = some_pose(-0.4);
  const SE3 camera_from_new = on_new_keyframe(camera_from_before, before_from_new);
  const Eigen::Vector3d in_new(0.4, -0.7, 1.3);
  const Eigen::Vector3d in_camera = camera_from_before * (before_from_new * in_new);
  EXPECT_LT((2.5 * (camera_from_new * in_new) - in_camera).norm(), 1e-12);
}

TEST(LsdMotion, TheVelocityGoesOnInTheNewUnit) {
  LsdMotion motion;
  motion.accept(0, some_pose(0.1));
  motion.accept(10, some_pose(0.2));
  const SE3 velocity = motion.velocity, pose = motion.camera_from_keyframe;
  const Sim3 before_from_new = Sim3(pose.inverse()) * Sim3(0.5, SO3(), Eigen::Vector3d::Zero());
  motion.change_keyframe(before_from_new);
  EXPECT_LT(motion.camera_from_keyframe.log().norm(), 1e-12) << "the frame is the keyframe";
  EXPECT_LT((motion.velocity.translation() - 2.0 * velocity.translation()).norm(), 1e-12);
  EXPECT_LT((motion.velocity.rotation().inverse() * velocity.rotation()).log().norm(), 1e-12);
}

TEST(LsdMotion, NoVelocityIsKnownAcrossALoss) {
  LsdMotion motion;
  motion.accept(0, some_pose(0.1));
  motion.lost = true;
  motion.lost_frames = 3;
  motion.accept(50, some_pose(0.5));
  EXPECT_EQ(motion.velocity.log().norm(), 0.0);
  EXPECT_EQ(motion.lost_frames, 0);
  EXPECT_EQ(motion.within(10).log().norm(), 0.0);
}

TEST(LsdMotion, AnAccelerationTakesTheCameraAsFarAsTheTimeAllows) {
  constexpr TimeNs frame = 50'000'000;
  LsdMotion motion;
  motion.accept(frame, some_pose(0.1));
  motion.duration = 0;
  EXPECT_EQ(motion.step_until(2 * frame, 15.0), std::numeric_limits<double>::infinity()) << "no velocity is known";
  motion.accept(2 * frame, some_pose(0.2));
  EXPECT_NEAR(motion.step_until(3 * frame, 15.0), 15.0 * 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(motion.step_until(4 * frame, 15.0), 15.0 * 0.1 * 0.1, 1e-12);
}

}  // namespace
}  // namespace rastro
