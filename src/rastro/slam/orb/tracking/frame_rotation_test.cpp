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

/// Every other feature is `off_px` above, below, left or right of where it should be, and `bits` of each descriptor are
/// wrong.
std::shared_ptr<const ImageFeatures> disturbed(const std::shared_ptr<const ImageFeatures>& frame, float off_px,
                                               int bits) {
  auto changed = std::make_shared<ImageFeatures>(*frame);
  for (std::size_t i = 0; i < changed->features.size(); ++i) {
    Keypoint& keypoint = changed->features.keypoints[i];
    if (i % 2 == 1) (i % 8 < 4 ? keypoint.x : keypoint.y) += i % 4 == 1 ? off_px : -off_px;
    for (int bit = 0; bit < bits; ++bit) changed->features.descriptors[i].words[0] ^= std::uint64_t{1} << bit;
  }
  return changed;
}

/// 36 features, of which thirty must fit.
TEST(FrameRotation, NearPointsMayHaveAParallaxAndDescriptorsSomeWrongBits) {
  const testing::PointWorld world(300, 5);
  const auto first = features_at(world, 0, SE3(), {.to = 36}), second = features_at(world, 1, SE3(), {.to = 36});
  const auto known_after = [&](const std::shared_ptr<const ImageFeatures>& next) {
    FrameRotation rotation(world.camera, 1, nullptr);
    rotation.next(first);
    return rotation.next(next).has_value();
  };
  EXPECT_TRUE(known_after(disturbed(second, 5.6F, 0)));
  EXPECT_FALSE(known_after(disturbed(second, 6.4F, 0)));
  EXPECT_TRUE(known_after(disturbed(second, 0.0F, 50)));
  EXPECT_FALSE(known_after(disturbed(second, 0.0F, 51)));
  for (const std::uint32_t count : {29U, 30U})
    EXPECT_EQ(known_after(features_at(world, 1, SE3(), {.to = count})), count == 30);
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
