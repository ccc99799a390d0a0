// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/relocalizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::bare_keyframe;
using testing::CountingImages;
using testing::looking;
using testing::pose_near;
using testing::room_frame;
using testing::room_keyframe;
using testing::unknown_frame;
using testing::with_depth_noise;

/// Four keyframes that face the four walls.
class RelocalizerTest : public ::testing::Test {
 protected:
  RelocalizerTest() {
    for (int k = 0; k < 4; ++k) {
      poses_.push_back(looking({0.3 * std::cos(k * M_PI / 2), 0.3 * std::sin(k * M_PI / 2), 1.2}, k * M_PI / 2, -0.3));
      const Frame frame = room_frame(poses_.back(), k);
      keyframes_.push_back(room_keyframe(frame, k, options_));
      images_->add(k, frame);
    }
  }
  Relocalizer::Try find(const Frame& frame, std::uint64_t seed = 1) {
    return Relocalizer(options_, test_room::camera(), depths_, appearances_).find(frame, keyframes_, seed);
  }

  RgbdSlamOptions options_;
  KeyframeMatcher matcher_{options_, test_room::camera()};
  std::shared_ptr<CountingImages> images_ = std::make_shared<CountingImages>();
  DepthStore depths_{matcher_.surfaces(), images_};
  AppearanceCheck check_{test_room::camera()};
  AppearanceStore appearances_{check_, images_};
  std::vector<SE3> poses_;
  std::vector<std::shared_ptr<const ImageFeatures>> keyframes_;
};

TEST_F(RelocalizerTest, FindsTheKeyframeOfItsWallAndThePose) {
  options_.relocalize_last = 4;
  for (std::size_t k = 0; k < 4; ++k) {
    const SE3 ground_truth = poses_[k] * SE3(SO3::exp({0.03, -0.06, 0.05}), {0.05, 0.03, -0.04});
    const Relocalizer::Try tried = find(with_depth_noise(room_frame(ground_truth), options_, k));
    ASSERT_TRUE(tried.found) << k;
    EXPECT_EQ(tried.found->keyframe, static_cast<std::int64_t>(k));
    EXPECT_THAT(poses_[k] * tried.found->constraint.a_from_b, pose_near(ground_truth, 0.03, 0.015)) << k;
    EXPECT_GE(tried.found->constraint.inliers, options_.relocalize_inliers);
    EXPECT_EQ(tried.compared, 4);
    EXPECT_GT(tried.features, 100);
  }
}

TEST_F(RelocalizerTest, OfSeveralKeyframesTheOneWithMostInliersCounts) {
  options_.relocalize_last = 5;
  // Close to keyframe 1, and even closer to a fifth one beside it.
  const SE3 ground_truth = poses_[1] * SE3(SO3::exp({0.0, 0.12, 0.0}), {0.1, 0.0, 0.0});
  const Frame beside = room_frame(ground_truth * SE3(SO3(), {0.005, 0.0, 0.0}), 4);
  keyframes_.push_back(room_keyframe(beside, 4, options_));
  images_->add(4, beside);
  const Relocalizer::Try tried = find(room_frame(ground_truth));
  ASSERT_TRUE(tried.found);
  EXPECT_EQ(tried.found->keyframe, 4);
  std::swap(keyframes_[0], keyframes_[4]);  // in another order it is still the best
  images_->add(0, beside);
  const Relocalizer::Try swapped = find(room_frame(ground_truth));
  ASSERT_TRUE(swapped.found);
  EXPECT_EQ(swapped.found->keyframe, 0);
}

TEST_F(RelocalizerTest, AnUnknownPlaceIsNotFound) {
  options_.relocalize_last = 4;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Relocalizer::Try tried = find(unknown_frame(seed), seed);
    EXPECT_FALSE(tried.found) << seed;
    EXPECT_EQ(tried.compared, 4);
  }
  keyframes_.erase(keyframes_.begin() + 2);  // and no other wall replaces the missing one
  options_.relocalize_last = 3;
  EXPECT_FALSE(find(room_frame(poses_[2])).found);
}

TEST_F(RelocalizerTest, WithoutKeyframesOrFeaturesThereIsNothingToCompare) {
  std::vector<std::shared_ptr<const ImageFeatures>> none;
  Relocalizer relocalizer(options_, test_room::camera(), depths_, appearances_);
  EXPECT_EQ(relocalizer.find(room_frame(poses_[0]), none, 1).compared, 0);
  for (std::int64_t k = 0; k < 3; ++k) none.push_back(bare_keyframe(k, 0));
  const Relocalizer::Try tried = relocalizer.find(room_frame(poses_[0]), none, 1);
  EXPECT_EQ(tried.compared, 0) << "their features were given up";
  EXPECT_FALSE(tried.found);
  EXPECT_EQ(images_->asked(), 0);
}

/// Only the middle one of many keyframes matches the frame; trying all in order must reach it, whatever the random
/// draws.
TEST_F(RelocalizerTest, EveryKeyframeIsTriedEventually) {
  options_.relocalize_last = 1;
  options_.relocalize_random = 1;
  std::vector<std::shared_ptr<const ImageFeatures>> many;
  for (std::int64_t k = 0; k < 12; ++k) many.push_back(k == 7 ? keyframes_[2] : bare_keyframe(k, 0));
  images_->add(7, room_frame(poses_[2]));
  Relocalizer relocalizer(options_, test_room::camera(), depths_, appearances_);
  int tries = 0;
  while (tries < 12) {
    ++tries;
    const Relocalizer::Try tried = relocalizer.find(room_frame(poses_[2]), many, 5);
    if (!tried.found) continue;
    EXPECT_EQ(tried.found->keyframe, 7);
    break;
  }
  EXPECT_LE(tries, 8) << "0, 1, ... 7";
  EXPECT_GT(tries, 1) << "or the draw found it, which this seed must not";
}

TEST_F(RelocalizerTest, TheSameSeedGivesTheSame) {
  options_.relocalize_last = 4;
  const Frame frame = with_depth_noise(room_frame(poses_[3] * SE3(SO3(), {0.04, 0.0, 0.02})), options_, 8);
  const Relocalizer::Try once = find(frame, 3), again = find(frame, 3);
  ASSERT_TRUE(once.found && again.found);
  EXPECT_EQ(once.found->keyframe, again.found->keyframe);
  EXPECT_EQ(once.found->constraint.a_from_b.matrix(), again.found->constraint.a_from_b.matrix());
}

}  // namespace
}  // namespace rastro
