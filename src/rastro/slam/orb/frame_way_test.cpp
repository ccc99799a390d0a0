// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/frame_way.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::Look;
using testing::PointWorld;
using testing::pose_near;

constexpr TimeNs tenth = 100000000;

SE3 world_from_way(double metres) { return SE3(SO3::exp({0.0, 0.1 * metres, 0.02}), {metres, 0.1 * metres, 0.0}); }

/// As tracking hands it over: standing at `world_from_camera`, relative to a keyframe of the graph.
PlacedFrame placed(const MapGraph& graph, std::int64_t index, std::int64_t keyframe, const SE3& world_from_camera) {
  PlacedFrame frame;
  frame.index = index;
  frame.stamp = tenth * index;
  frame.keyframe = keyframe;
  frame.camera_from_keyframe = (graph.camera_from_world(keyframe) * world_from_camera).inverse();
  frame.unit = graph.unit(keyframe);
  return frame;
}

/// A map of two keyframes and a way past them.
struct WayBench {
  explicit WayBench(CameraKind sensor = CameraKind::mono)
      : map(world, sensor, sensor == CameraKind::mono ? 0.0 : 0.1) {
    map.add(0, world_from_way(0.0).inverse());
    map.add(1, world_from_way(1.0).inverse());
  }
  /// `error` away from `world_from_camera`, but with all that is seen from there.
  PlacedFrame seeing(std::int64_t index, std::int64_t keyframe, const SE3& world_from_camera, const SE3& error) {
    const Look look = world.look(100 + index, world_from_camera.inverse(), {.baseline = map.graph.baseline()});
    PlacedFrame frame = placed(map.graph, index, keyframe, world_from_camera * error);
    for (const TrackedPoint& point : map.tracked(look)) {
      const Eigen::Vector2d ray = look.frame->ray(point.feature);
      frame.seen.push_back({point.landmark, ray.cast<float>(), static_cast<float>(look.frame->right_ray(point.feature)),
                            static_cast<float>(map.graph.sigma(*look.frame, point.feature))});
    }
    return frame;
  }

  PointWorld world{120, 3};
  ExactMap map;
  FrameWay way;
};

/// A frame of which only its keyframe matters.
PlacedFrame beside(std::int64_t index, std::int64_t keyframe) {
  PlacedFrame frame;
  frame.index = index;
  frame.stamp = tenth * index;
  frame.keyframe = keyframe;
  return frame;
}

const SE3 some_error(SO3::exp({0.02, -0.01, 0.03}), {0.05, -0.04, 0.06});

TEST(FrameWay, IsInTheOrderOfTheRecordingHoweverFramesCome) {
  WayBench bench;
  for (const int index : {3, 1, 4, 2})
    bench.way.add(placed(bench.map.graph, index, index % 2, world_from_way(0.2 * index)));
  const Trajectory way = bench.way.trajectory(bench.map.graph, 0);
  ASSERT_EQ(way.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(bench.way.frames()[static_cast<std::size_t>(i)].index, i + 1);
    EXPECT_EQ(way[static_cast<std::size_t>(i)].stamp, tenth * (i + 1));
    EXPECT_THAT(way[static_cast<std::size_t>(i)].world_from_body, pose_near(world_from_way(0.2 * (i + 1)), 1e-9, 1e-9));
  }
}

TEST(FrameWay, FramesGoWhereTheirKeyframeGoes) {
  WayBench bench;
  bench.way.add(placed(bench.map.graph, 1, 0, world_from_way(0.2)));
  bench.way.add(placed(bench.map.graph, 2, 1, world_from_way(0.8)));
  const SE3 shift(SO3::exp({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0});
  bench.map.graph.keyframe(1).camera_from_world = (shift * world_from_way(1.0)).inverse();
  const Trajectory way = bench.way.trajectory(bench.map.graph, 0);
  EXPECT_THAT(way[0].world_from_body, pose_near(world_from_way(0.2), 1e-9, 1e-9));
  EXPECT_THAT(way[1].world_from_body, pose_near(shift * world_from_way(0.8), 1e-9, 1e-9));
}

TEST(FrameWay, GrowsWithTheMap) {
  WayBench bench;
  bench.way.add(placed(bench.map.graph, 1, 1, world_from_way(0.5)));
  const Sim3 grown(2.5, SO3::exp({0.3, -0.1, 0.2}), {1.0, -2.0, 0.5});
  bench.map.graph.transform(0, grown);
  // Placed in the larger unit already.
  bench.way.add(placed(bench.map.graph, 2, 1, SE3(SO3(), {7.0, 8.0, 9.0})));
  const Trajectory way = bench.way.trajectory(bench.map.graph, 0);
  const SE3 expected(grown.rotation() * world_from_way(0.5).rotation(), grown * world_from_way(0.5).translation());
  EXPECT_THAT(way[0].world_from_body, pose_near(expected, 1e-9, 1e-9));
  EXPECT_THAT(way[1].world_from_body, pose_near(SE3(SO3(), {7.0, 8.0, 9.0}), 1e-9, 1e-9));
}

TEST(FrameWay, FramesOfARemovedKeyframeStayWhereTheyAre) {
  WayBench bench;
  bench.way.add(placed(bench.map.graph, 1, 1, world_from_way(0.7)));
  bench.map.graph.remove_keyframe(1);
  const Trajectory way = bench.way.trajectory(bench.map.graph, 0);
  ASSERT_EQ(way.size(), 1U);
  EXPECT_THAT(way[0].world_from_body, pose_near(world_from_way(0.7), 1e-9, 1e-9));
}

TEST(FrameWay, TheLastPoseIsRepeatedOnlyLater) {
  WayBench bench;
  EXPECT_FALSE(bench.way.repeat_last(1, tenth));
  bench.way.add(placed(bench.map.graph, 3, 0, world_from_way(0.3)));
  EXPECT_FALSE(bench.way.repeat_last(3, 4 * tenth));
  EXPECT_FALSE(bench.way.repeat_last(4, 3 * tenth));
  EXPECT_EQ(bench.way.frames().size(), 1U);
  EXPECT_TRUE(bench.way.repeat_last(4, 3 * tenth + 1));
  const Trajectory way = bench.way.trajectory(bench.map.graph, 0);
  ASSERT_EQ(way.size(), 2U);
  EXPECT_EQ(bench.way.frames()[1].index, 4);
  EXPECT_EQ(way[1].stamp, 3 * tenth + 1);
  EXPECT_THAT(way[1].world_from_body, pose_near(world_from_way(0.3), 1e-9, 1e-9));
}

TEST(FrameWay, ASubmapThatIsForgottenTakesItsFramesAlong) {
  WayBench bench;
  bench.map.add(2, world_from_way(5.0).inverse(), {}, 1);
  for (const int index : {1, 2, 3, 4, 5}) bench.way.add(beside(index, index % 2 == 0 ? 2 : 1));
  EXPECT_EQ(bench.way.trajectory(bench.map.graph, 1).size(), 2U);
  EXPECT_EQ(bench.way.largest_submap(bench.map.graph), 0);
  bench.way.forget(bench.map.graph, 0);
  ASSERT_EQ(bench.way.frames().size(), 2U);
  EXPECT_EQ(bench.way.frames()[0].index, 2);
  EXPECT_EQ(bench.way.frames()[1].index, 4);
  EXPECT_TRUE(bench.way.trajectory(bench.map.graph, 0).empty());
  EXPECT_EQ(bench.way.largest_submap(bench.map.graph), 1);
}

TEST(FrameWay, OfSubmapsOfOneSizeTheFirstIsTheLargest) {
  WayBench bench;
  EXPECT_EQ(bench.way.largest_submap(bench.map.graph), 0);
  bench.map.add(2, world_from_way(5.0).inverse(), {}, 1);
  bench.way.add(beside(1, 2));
  bench.way.add(beside(2, 0));
  EXPECT_EQ(bench.way.largest_submap(bench.map.graph), 0);
  bench.way.add(beside(3, 2));
  EXPECT_EQ(bench.way.largest_submap(bench.map.graph), 1);
}

TEST(FrameWay, SettlingPutsAFrameWhereItsLandmarksSay) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    WayBench bench(sensor);
    bench.way.add(bench.seeing(1, 1, world_from_way(0.4), some_error));
    const auto pose = [&]() -> SE3 { return bench.way.trajectory(bench.map.graph, 0)[0].world_from_body; };
    EXPECT_THAT(pose(), pose_near(world_from_way(0.4) * some_error, 1e-9, 1e-9));
    bench.way.settle(bench.map.graph, 30);
    EXPECT_THAT(pose(), pose_near(world_from_way(0.4), 1e-4, 1e-4));
  }
}

TEST(FrameWay, SettlesInAMapThatHasGrownSince) {
  WayBench bench;
  bench.way.add(bench.seeing(1, 1, world_from_way(0.4), some_error));
  const Sim3 grown(2.0, SO3(), {0.0, 0.0, 1.0});
  bench.map.graph.transform(0, grown);
  bench.way.settle(bench.map.graph, 30);
  const SE3 expected(world_from_way(0.4).rotation(), grown * world_from_way(0.4).translation());
  EXPECT_THAT(bench.way.trajectory(bench.map.graph, 0)[0].world_from_body, pose_near(expected, 2e-4, 1e-4));
  EXPECT_EQ(bench.way.frames()[0].unit, 2.0);
}

TEST(FrameWay, AFrameOfWhichTooLittleFitsStays) {
  WayBench bench;
  PlacedFrame frame = bench.seeing(1, 1, world_from_way(0.4), some_error);
  frame.seen.resize(20);
  bench.way.add(frame);
  bench.way.settle(bench.map.graph, 21);
  EXPECT_THAT(bench.way.trajectory(bench.map.graph, 0)[0].world_from_body,
              pose_near(world_from_way(0.4) * some_error, 1e-9, 1e-9));
  bench.way.settle(bench.map.graph, 20);
  EXPECT_THAT(bench.way.trajectory(bench.map.graph, 0)[0].world_from_body, pose_near(world_from_way(0.4), 1e-4, 1e-4));
}

TEST(FrameWay, LandmarksThatAreGoneHoldNoFrameAndFusedOnesDo) {
  WayBench bench;
  MapGraph& graph = bench.map.graph;
  PlacedFrame frame = bench.seeing(1, 1, world_from_way(0.4), some_error);
  frame.seen.resize(20);
  bench.way.add(frame);
  // One more landmark where the first of them is takes its place; the second is gone.
  const std::int64_t twin = graph.add_landmark(graph.landmark(frame.seen[0].landmark).position, 0).id;
  graph.fuse(twin, frame.seen[0].landmark);
  graph.remove_landmark(frame.seen[1].landmark);
  bench.way.settle(graph, 20);
  EXPECT_THAT(bench.way.trajectory(graph, 0)[0].world_from_body,
              pose_near(world_from_way(0.4) * some_error, 1e-9, 1e-9));
  bench.way.settle(graph, 19);
  EXPECT_THAT(bench.way.trajectory(graph, 0)[0].world_from_body, pose_near(world_from_way(0.4), 1e-4, 1e-4));
}

TEST(FrameWay, LandmarksOfAnotherSubmapHoldNoFrame) {
  WayBench bench;
  bench.map.add(2, SE3(), {}, 1);
  bench.way.add(bench.seeing(1, 2, world_from_way(0.4), some_error));
  // All of its landmarks belong to the first submap, whose world is another.
  for (const std::int64_t id : bench.map.graph.landmark_ids()) bench.map.graph.remove_observation(2, id);
  bench.way.settle(bench.map.graph, 1);
  EXPECT_THAT(bench.way.trajectory(bench.map.graph, 1)[0].world_from_body,
              pose_near(world_from_way(0.4) * some_error, 1e-9, 1e-9));
}

TEST(FrameWay, AFrameThatBecameAKeyframeSettlesOnIt) {
  WayBench bench;
  const SE3 elsewhere = world_from_way(3.0);
  for (const int index : {1, 2, 3}) bench.way.add(placed(bench.map.graph, index, 0, world_from_way(0.1 * index)));
  bench.way.set_keyframe(2, 1);
  bench.way.set_keyframe(7, 1);
  bench.map.graph.keyframe(1).camera_from_world = elsewhere.inverse();
  bench.way.settle(bench.map.graph, 10);
  const Trajectory way = bench.way.trajectory(bench.map.graph, 0);
  ASSERT_EQ(way.size(), 3U);
  EXPECT_THAT(way[0].world_from_body, pose_near(world_from_way(0.1), 1e-9, 1e-9));
  EXPECT_THAT(way[1].world_from_body, pose_near(elsewhere, 1e-9, 1e-9));
  EXPECT_EQ(way[1].stamp, 2 * tenth);
  EXPECT_THAT(way[2].world_from_body, pose_near(world_from_way(0.3), 1e-9, 1e-9));
}

}  // namespace
}  // namespace rastro
