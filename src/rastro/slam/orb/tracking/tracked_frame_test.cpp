// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/tracked_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::Observed;
using testing::PointWorld;
using testing::pose_near;

TEST(TrackedFrame, IsRelativeToItsReferenceInTheViewAndHasItsObservations) {
  const PointWorld world(60, 5);
  ExactMap map(world, CameraKind::depth, 0.1);
  const SE3 first(SO3::exp({0.0, 0.1, 0.0}), {-0.1, 0.0, 0.0}), second(SO3(), {-0.3, 0.0, 0.0});
  map.add(0, first);
  map.add(1, second);
  map.graph.keyframe(1).unit = 1.5;
  const auto view = view_of(map.graph, 0, {});
  map.graph.transform(0, Sim3(2.0, SO3(), {1.0, 2.0, 3.0}));  // not in the view yet
  const SE3 pose(SO3::exp({0.02, 0.0, 0.01}), {-0.2, 0.1, 0.0});
  const Observed observed = world.observe(7, pose, {.baseline = 0.1});
  TrackingResult tracked;
  tracked.camera_from_world = pose;
  tracked.reference = 1;
  tracked.points = map.tracked(observed);
  ASSERT_EQ(tracked.points.size(), 60U);
  tracked.points[3].landmark = -1;
  const TrackedFrame frame = tracked_frame(map.graph, *view, *observed.frame, tracked, 2.0);
  EXPECT_EQ(frame.index, 7);
  EXPECT_EQ(frame.stamp, observed.frame->data().stamp);
  EXPECT_EQ(frame.keyframe, 1);
  EXPECT_EQ(frame.unit, 1.5);
  EXPECT_EQ(frame.became, -1);
  EXPECT_THAT(frame.camera_from_keyframe, pose_near(pose * second.inverse(), 1e-12, 1e-12));
  ASSERT_TRUE(frame.measured);
  const std::vector<FrameObservation>& seen = frame.measured->seen;
  ASSERT_EQ(seen.size(), 59U) << "what is no landmark yet is left out";
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const std::uint32_t feature = tracked.points[i < 3 ? i : i + 1].feature;
    const std::uint32_t point = observed.seen[feature];
    const Eigen::Vector3d in_camera = pose * world.points[point];
    EXPECT_EQ(seen[i].landmark, map.landmark_of[point]);
    EXPECT_NEAR(seen[i].ray.x(), in_camera.x() / in_camera.z(), 1e-5);
    EXPECT_NEAR(seen[i].ray.y(), in_camera.y() / in_camera.z(), 1e-5);
    EXPECT_NEAR(seen[i].right, (in_camera.x() - 0.1) / in_camera.z(), 1e-5);
    EXPECT_FLOAT_EQ(seen[i].sigma, static_cast<float>(2.0 * std::pow(1.2, observed.frame->level(feature)) / 500.0));
  }
}

TEST(TrackedFrame, OfAKeyframeHasItsPose) {
  const PointWorld world(60, 5);
  ExactMap map(world, CameraKind::mono, 0.0);
  map.add(4, SE3(SO3(), {-0.3, 0.0, 0.0}));
  map.graph.keyframe(4).unit = 0.25;
  const Observed observed = world.observe(9, SE3());
  const TrackedFrame frame = tracked_keyframe(map.graph, *observed.frame, 4);
  EXPECT_EQ(frame.index, 9);
  EXPECT_EQ(frame.stamp, observed.frame->data().stamp);
  EXPECT_EQ(frame.keyframe, 4);
  EXPECT_EQ(frame.became, 4);
  EXPECT_EQ(frame.unit, 0.25);
  EXPECT_THAT(frame.camera_from_keyframe, pose_near(SE3(), 0.0, 0.0));
  EXPECT_FALSE(frame.measured);
}

TEST(TrackedFrame, WithoutLandmarksIsOnlyRemembered) {
  const PointWorld world(60, 5);
  ExactMap map(world, CameraKind::depth, 0.1);
  map.add(0, SE3());
  TrackingResult tracked;
  tracked.reference = 0;
  EXPECT_FALSE(
      tracked_frame(map.graph, *view_of(map.graph, 0, {}), *world.observe(7, SE3()).frame, tracked, 1.0).measured);
}

}  // namespace
}  // namespace rastro
