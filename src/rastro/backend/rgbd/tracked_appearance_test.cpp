// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/tracked_appearance.h"

#include <gtest/gtest.h>

#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::looking;
using testing::room_frame;

class TrackedAppearances : public ::testing::Test {
 protected:
  TrackedAppearances() {
    tracked_.keep(room_frame(view_, 0));
    tracked_.note(room_frame(view_, 0).stamp);
  }
  bool contradicts(const Frame& frame, const SE3& keyframe_from_frame) const {
    return tracked_.contradiction(frame, keyframe_from_frame).has_value();
  }
  Frame frame_after(int frames, const SE3& world_from_camera) const { return room_frame(world_from_camera, frames); }

  AppearanceCheck check_ = AppearanceCheck(test_room::camera());
  TrackedAppearance tracked_ = TrackedAppearance(check_);
  SE3 view_ = looking({-0.5, -0.2, 1.2}, -0.3, -0.3), moved_ = looking({-0.3, -0.1, 1.2}, -0.25, -0.3);
  SE3 right_ = view_.inverse() * moved_;
};

TEST_F(TrackedAppearances, TheRightPoseLooksLikeIt) { EXPECT_FALSE(contradicts(frame_after(30, moved_), right_)); }

TEST_F(TrackedAppearances, AWrongPoseDoesNot) {
  const auto found = tracked_.contradiction(frame_after(30, moved_), right_ * SE3(SO3(), {0.2, 0.0, 0.0}));
  ASSERT_TRUE(found);
  EXPECT_GT(found->contradict, found->agree);
}

TEST_F(TrackedAppearances, OnlyWhatFollowsAGapIsCompared) {
  const SE3 wrong = right_ * SE3(SO3(), {0.2, 0.0, 0.0});
  EXPECT_FALSE(contradicts(frame_after(8, moved_), wrong));
  EXPECT_TRUE(contradicts(frame_after(11, moved_), wrong));
  tracked_.note(frame_after(10, moved_).stamp);
  EXPECT_FALSE(contradicts(frame_after(11, moved_), wrong));
}

TEST_F(TrackedAppearances, WithoutImagesOrDepthNothingIsCompared) {
  const SE3 wrong = right_ * SE3(SO3(), {0.2, 0.0, 0.0});
  Frame without_depth = frame_after(30, moved_);
  without_depth.depth = {};
  EXPECT_FALSE(contradicts(without_depth, wrong));
  tracked_.forget();
  EXPECT_FALSE(contradicts(frame_after(30, moved_), wrong));
  tracked_.keep(without_depth);
  EXPECT_FALSE(contradicts(frame_after(30, moved_), wrong));
}

}  // namespace
}  // namespace rastro
