// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/frame_rotation.h"

#include <gtest/gtest.h>

#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

std::shared_ptr<const ImageFeatures> features_at(const testing::PointWorld& world, std::int64_t id, const SE3& pose,
                                                 const testing::ObserveOptions& options = {}) {
  return std::make_shared<ImageFeatures>(world.observe(id, pose, options).frame->data());
}

TEST(FrameRotation, IsThatOfTheSceneInTheCameraOverTheFrameInterval) {
  const testing::PointWorld world(300, 5);
  const Eigen::Vector3d rotated(0.02, -0.05, 0.01);
  FrameRotation rotation(world.camera, 1, nullptr);
  EXPECT_FALSE(rotation.next(features_at(world, 0, SE3()))) << "of the first frame nothing is known";
  const auto found = rotation.next(features_at(world, 1, SE3(SO3::exp(rotated), {0.01, 0.0, 0.0}), {.noise_px = 0.5}));
  ASSERT_TRUE(found);
  EXPECT_LT((*found - rotated / 0.1).norm(), 0.03) << "PointWorld's frames are 0.1 s from each other";
}

TEST(FrameRotation, IsUnknownWithoutCommonFeaturesAndBetweenEqualStamps) {
  const testing::PointWorld world(300, 5), other(300, 99);
  FrameRotation rotation(world.camera, 1, nullptr);
  rotation.next(features_at(world, 0, SE3()));
  EXPECT_FALSE(rotation.next(features_at(other, 1, SE3())));
  EXPECT_FALSE(rotation.next(features_at(other, 1, SE3()))) << "no time has passed";
  EXPECT_TRUE(rotation.next(features_at(other, 2, SE3()))) << "from the last frame given";
}

}  // namespace
}  // namespace rastro
