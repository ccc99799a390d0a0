// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/keyframe_insertion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/session_testing.h"

namespace rastro {
namespace {

using testing::Observed;
using testing::PointWorld;
using testing::pose_near;
using testing::SessionBench;

/// No keyframe is culled, none is made for new depths alone, and shares are exact.
OrbSlamOptions plain_options() {
  OrbSlamOptions options;
  options.keyframe_share = 0.75;
  options.keyframe_share_depth = 0.5;
  options.keyframe_few_points = 0;
  options.cull_seen_share = 1.0;
  return options;
}

/// Keyframes 0 to 2 have 100 landmarks, keyframe 3 has 40 of them.
struct InsertionBench : SessionBench {
  explicit InsertionBench(CameraKind sensor, const OrbSlamOptions& options = plain_options())
      : SessionBench(sensor, options), observed(observe(10, stop(2.1))) {
    begin(3, {.to = 100});
    map.add(3, stop(3), {.to = 40});
    session.next_keyframe = 4;
    session.frame_number = 1;
    tracker.set_view(view_of(session.graph, 3, session.view_options()));
  }
  bool needed(int inliers, std::int64_t reference = 1) const {
    TrackingResult result = tracked(observed, stop(2.1), reference);
    result.inliers = inliers;
    return keyframes.needs_keyframe(*observed.frame, result);
  }

  Observed observed;
};

TEST(KeyframeInsertion, IsRefusedWhileEnoughOfTheReferencesLandmarksAreTracked) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    const InsertionBench bench(sensor);
    ASSERT_EQ(bench.tracker.view()->keyframe(1).landmarks, 100);
    const int of_100 = sensor == CameraKind::mono ? 75 : 50, of_40 = sensor == CameraKind::mono ? 30 : 20;
    EXPECT_FALSE(bench.needed(of_100));
    EXPECT_TRUE(bench.needed(of_100 - 1));
    EXPECT_FALSE(bench.needed(of_40, 3)) << "a share of the reference's own";
    EXPECT_TRUE(bench.needed(of_40 - 1, 3));
  }
}

TEST(KeyframeInsertion, HappensAfterTheGivenFramesOnceAnyLandmarkIsMissing) {
  InsertionBench bench(CameraKind::mono);
  bench.session.frame_number = 5;
  bench.keyframes.on_initialized();
  bench.session.frame_number = 5 + 20;
  EXPECT_FALSE(bench.needed(99));
  bench.session.frame_number = 5 + 21;
  EXPECT_TRUE(bench.needed(99));
  EXPECT_FALSE(bench.needed(100));
}

TEST(KeyframeInsertion, IsRefusedUntilARelocalizedPoseHasSettled) {
  InsertionBench bench(CameraKind::mono);
  bench.session.frame_number = 100;
  bench.keyframes.on_relocalized(20);
  EXPECT_FALSE(bench.needed(10));
  EXPECT_TRUE(bench.needed(9)) << "most of what was seen then is out of view";
  bench.session.frame_number = 119;
  EXPECT_FALSE(bench.needed(10)) << "overdue or not";
  bench.session.frame_number = 120;
  EXPECT_TRUE(bench.needed(10));
  bench.session.frame_number = 110;
  bench.keyframes.on_initialized();
  EXPECT_TRUE(bench.needed(10)) << "the map is another";
}

TEST(KeyframeInsertion, WaitsForMappingUnlessOverdue) {
  InsertionBench bench(CameraKind::mono);
  bench.session.frame_number = 7;
  SlamUpdate update;
  bench.keyframes.insert(bench.observed.frame, bench.tracked(bench.observed, bench.stop(2.1), 2), update);
  bench.session.frame_number = 7 + 20;
  EXPECT_FALSE(bench.needed(10));
  bench.session.frame_number = 7 + 21;
  EXPECT_TRUE(bench.needed(10));
  EXPECT_FALSE(bench.needed(100));
  bench.session.frame_number = 8;
  bench.pipeline.take_all_results(update.events);
  EXPECT_TRUE(bench.needed(10));
}

/// A world whose first points are at the limit of what counts as near, beyond it, and too far for any depth.
PointWorld world_with_limits() {
  PointWorld world(300, 5);
  world.points[0] = {0.4, 0.1, 8.0};
  world.points[1] = {0.4, 0.3, 8.01};
  world.points[2] = {100.0, 50.0, 6000.0};
  return world;
}

/// New depths in a frame whose points from `taken` on observe landmarks.
struct NewDepthBench : SessionBench {
  NewDepthBench(CameraKind sensor, const OrbSlamOptions& options)
      : SessionBench(sensor, options, {}, world_with_limits()) {
    begin(3);
    session.frame_number = 1;
    observed = observe(10, stop(0));
  }
  bool needed(std::uint32_t taken, int inliers) const {
    TrackingResult result = tracked(observed, stop(0), 1);
    std::erase_if(result.points, [&](const TrackedPoint& point) { return observed.seen[point.feature] < taken; });
    result.inliers = inliers;
    return keyframes.needs_keyframe(*observed.frame, result);
  }
  int near_before(std::uint32_t taken) const {
    int count = 0;
    for (std::uint32_t point = 0; point < taken; ++point) count += world.points[point].z() <= 8.0 ? 1 : 0;
    return count;
  }

  Observed observed;
};

TEST(KeyframeInsertion, HappensIfEnoughNearDepthsHaveNoLandmark) {
  OrbSlamOptions options = plain_options();
  options.far_baselines = 20.0;  // 8 m
  options.keyframe_few_points = 200;
  options.keyframe_new_points = NewDepthBench(CameraKind::depth, options).near_before(100);
  ASSERT_GT(options.keyframe_new_points, 20);
  ASSERT_LT(options.keyframe_new_points, 80);
  const NewDepthBench enough(CameraKind::depth, options);
  EXPECT_FALSE(enough.needed(100, 199)) << "exactly as many as are let be";
  std::uint32_t one_more = 101;
  while (enough.near_before(one_more) == options.keyframe_new_points) ++one_more;
  EXPECT_TRUE(enough.needed(one_more, 199));
  EXPECT_FALSE(enough.needed(one_more, 200)) << "the old is tracked well enough";
  EXPECT_FALSE(NewDepthBench(CameraKind::mono, options).needed(300, 230)) << "one camera has no depths";
}

TEST(KeyframeInsertion, AddsTheKeyframeToMapTrajectoryAndTracker) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    InsertionBench bench(sensor);
    const MapGraph& graph = bench.session.graph;
    TrackedFrame recorded;
    recorded.index = 10;
    bench.session.trajectory.add(recorded);
    const TrackingResult result = bench.tracked(bench.observed, bench.stop(2.1), 2);
    const std::int64_t both = bench.map.landmark_of[0], missed = bench.map.landmark_of[1];
    TrackingResult counted;
    counted.visible = {both, missed};
    counted.points = {{.feature = 0, .landmark = both, .keyframe = -1, .keyframe_feature = 0, .position = {}}};
    TrackedPoint of_depth;
    of_depth.feature = 5;
    counted.points.push_back(of_depth);
    bench.session.frame_number = 30;
    bench.keyframes.count_observations(counted);
    bench.keyframes.count_observations(counted);
    SlamUpdate update;
    bench.keyframes.insert(bench.observed.frame, result, update);
    ASSERT_EQ(update.events.size(), 1U);
    EXPECT_EQ(update.events[0].kind, "keyframe");
    EXPECT_EQ(update.events[0].detail, "4");
    EXPECT_EQ(bench.session.next_keyframe, 5);
    EXPECT_EQ(bench.session.trajectory.frames()[0].became, 4);
    ASSERT_TRUE(graph.has_keyframe(4));
    EXPECT_EQ(graph.keyframe(4).frame->data().frame, 10);
    EXPECT_THAT(graph.camera_from_world(4), pose_near(bench.stop(2.1), 1e-3, 1e-4));
    EXPECT_EQ(graph.landmark(both).visible, 3);
    EXPECT_EQ(graph.landmark(both).found, 3);
    EXPECT_EQ(graph.landmark(missed).visible, 3);
    EXPECT_EQ(graph.landmark(missed).found, 1);
    EXPECT_FALSE(bench.pipeline.idle());
    EXPECT_EQ(bench.tracker.view()->center, 3) << "mapping hands its view over later";
    // Points with depth are tracked until mapping hands them over.
    const TrackingResult next = bench.tracker.track_from(bench.observe(11, bench.stop(2.2)).frame, bench.stop(2.2));
    std::size_t of_new = 0;
    for (const TrackedPoint& point : next.points) of_new += point.keyframe == 4 ? 1U : 0U;
    if (sensor == CameraKind::mono) {
      EXPECT_EQ(of_new, 0U);
    } else {
      EXPECT_GT(of_new, 190U);
    }
    // The next one starts counting at zero.
    bench.pipeline.take_all_results(update.events);
    bench.session.frame_number = 50;
    EXPECT_FALSE(bench.needed(99)) << "20 frames after it";
    const Observed later = bench.observe(12, bench.stop(2.3));
    bench.keyframes.insert(later.frame, bench.tracked(later, bench.stop(2.3), 2), update);
    EXPECT_EQ(graph.landmark(missed).visible, 3);
  }
}

TEST(KeyframeInsertion, IsRelativeToItsReferenceInTheCurrentUnitOfTheMap) {
  InsertionBench bench(CameraKind::mono);
  TrackingResult result = bench.tracked(bench.observed, bench.stop(2.1), 1);
  result.points.clear();  // only the reference determines its pose
  bench.session.graph.transform(0, Sim3(2.0, SO3(), Eigen::Vector3d(1.0, 0.0, 0.0)));
  SlamUpdate update;
  bench.keyframes.insert(bench.observed.frame, result, update);
  EXPECT_THAT(bench.session.graph.camera_from_world(4), pose_near(SE3(SO3(), {-0.84 - 1.0, 0.0, 0.0}), 1e-9, 1e-9));
}

TEST(KeyframeInsertion, InsertNowCentersTheViewAtTheNewKeyframe) {
  InsertionBench bench(CameraKind::mono);
  bench.keyframes.insert_now(bench.observed.frame, bench.tracked(bench.observed, bench.stop(2.1), 2));
  EXPECT_TRUE(bench.pipeline.idle());
  EXPECT_EQ(bench.tracker.view()->center, 4);
  EXPECT_EQ(bench.session.next_keyframe, 5);
  EXPECT_THAT(bench.session.graph.camera_from_world(4), pose_near(bench.stop(2.1), 1e-3, 1e-4));
}

TEST(KeyframeInsertion, ForgottenObservationsAreNotCounted) {
  InsertionBench bench(CameraKind::mono);
  TrackingResult result = bench.tracked(bench.observed, bench.stop(2.1), 2);
  const std::int64_t landmark = bench.map.landmark_of[0];
  result.visible = {landmark};
  bench.keyframes.count_observations(result);
  bench.keyframes.forget_observations();
  bench.keyframes.insert_now(bench.observed.frame, result);
  EXPECT_EQ(bench.session.graph.landmark(landmark).visible, 1);
  EXPECT_EQ(bench.session.graph.landmark(landmark).found, 1);
}

}  // namespace
}  // namespace rastro
