// SPDX-License-Identifier: Apache-2.0
// What the keyframe that a tracker refers to is used for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::ObserveOptions;
using testing::PointWorld;
using testing::pose_near;

SE3 beside_origin(double x) { return SE3(SO3(), {-x, 0.0, 0.0}); }

/// Beyond every search around a predicted pose.
SE3 turned_over() { return SE3(SO3::exp({0.05, 0.03, 3.0}), {-0.2, 0.1, 0.1}); }

/// Its reference, or the newest keyframe while there is none or it is gone.
TEST(FrameTrackerReference, ThePoseMovesWithItsReference) {
  for (const int reference : {0, 1, -1}) {
    const PointWorld world(300, 5);
    ExactMap map(world, CameraKind::mono, 0.0);
    map.add(0, beside_origin(0.0), {.from = 0, .to = 200});
    map.add(1, beside_origin(0.1), {.from = 100, .to = 300});
    map.add(2, beside_origin(0.2), {.from = 150, .to = 250});
    FrameTracker tracker({}, world.camera, CameraKind::mono, 0.0);
    tracker.set_view(view_of(map.graph, 2, {}));
    const ObserveOptions how{.from = reference == 0 ? 0U : 260U, .to = reference == 0 ? 90U : 300U};
    if (reference >= 0) {
      ASSERT_EQ(tracker.track_from(world.observe(7, beside_origin(0.1), how).frame, beside_origin(0.1)).reference,
                reference);
    } else {
      tracker.restart(beside_origin(0.1), {}, nullptr);
    }
    const SE3 before = tracker.last_pose(), moved(SO3::exp({0.1, 0.2, -0.1}), {1.0, 2.0, 3.0});
    const std::int64_t with = reference >= 0 ? reference : 2;
    SE3& pose = map.graph.keyframe(with).camera_from_world;
    pose = pose * moved;
    tracker.set_view(view_of(map.graph, 2, {}));
    EXPECT_THAT(tracker.last_pose(), pose_near(before * moved, 1e-9, 1e-9)) << reference;
  }
}

/// Whether the tracker finds a frame after a jerk that shows so many landmarks, if a guess needs this many.
bool found_after_jerk(std::uint32_t shown, int min_guess_inliers) {
  const PointWorld world(300, 5);
  ExactMap map(world, CameraKind::mono, 0.0);
  map.add(0, beside_origin(0.0));
  OrbSlamOptions options;
  options.min_guess_inliers = min_guess_inliers;
  options.min_inliers = 8;
  options.min_chance_ratio = 0.0;
  FrameTracker tracker(options, world.camera, CameraKind::mono, 0.0);
  tracker.set_view(view_of(map.graph, 0, {}));
  tracker.track_from(world.observe(7, beside_origin(0.1)).frame, beside_origin(0.1));
  return tracker.track(world.observe(8, turned_over(), {.from = 100, .to = 100 + shown}).frame).ok;
}

TEST(FrameTrackerReference, AJerkIsFoundWithHalfTheInliersOfAGuess) {
  const std::size_t shown = PointWorld(300, 5).observe(8, turned_over(), {.from = 100, .to = 120}).seen.size();
  ASSERT_GT(shown, 8U);
  const int most = 2 * static_cast<int>(shown);
  EXPECT_TRUE(found_after_jerk(20, most));
  EXPECT_TRUE(found_after_jerk(20, most + 1));
  EXPECT_FALSE(found_after_jerk(20, most + 2));
}

}  // namespace
}  // namespace rastro
