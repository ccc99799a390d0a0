// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/map_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/map/graph_testing.h"

namespace rastro {
namespace {

using testing::add_landmark;
using testing::blank_frame;
using testing::pose_near;
using KeyframeIds = std::vector<std::int64_t>;

SE3 camera_at(double x) { return SE3(SO3::exp({0.0, 0.1 * x, 0.0}), {-x, 0.0, 0.0}); }

OrbOptions extraction() { return {.features = 77, .levels = 8, .scale_factor = 1.2}; }

MapGraph empty_graph(CameraKind sensor = CameraKind::depth) {
  return MapGraph(testing::small_camera(), sensor, sensor == CameraKind::mono ? 0.0 : 0.1, extraction());
}

/// Keyframes 0, 1 and 4 of one submap, 2 and 3 of another; three landmarks, the last without observations.
struct ExportBench {
  ExportBench() {
    add(0, 0, -1);
    add(1, 0, 0);
    add(2, 1, -1);
    add(3, 1, 2);
    add(4, 0, 0);
    for (const std::uint32_t feature : {3U, 5U}) graph.describe(add_landmark(graph, feature, {0, 1, 4}));
    graph.add_landmark({1.0, 2.0, 3.0}, 0);
    Constraint constraint;
    constraint.from = 4;
    constraint.to = 0;
    constraint.inliers = 55;
    graph.constraints() = {constraint};
  }
  void add(std::int64_t id, int submap, std::int64_t parent) {
    graph.add_keyframe(blank_frame(id, 5.0, 0.1), camera_at(0.5 * static_cast<double>(id)), submap, parent);
  }
  void track(std::int64_t index, TimeNs stamp, std::int64_t keyframe, const SE3& camera_from_keyframe,
             double unit = 1.0) {
    recorded.add({index, stamp, keyframe, unit, camera_from_keyframe, -1, {}});
  }
  std::shared_ptr<const Map> map() const { return map_of(graph, recorded, std::nullopt); }

  MapGraph graph = empty_graph();
  FrameTrajectory recorded;
};

TEST(MapExport, ContainsAllOfTheGraph) {
  ExportBench bench;
  bench.track(1, 150, 0, SE3());
  bench.track(2, 250, 1, SE3());
  const auto map = bench.map();
  EXPECT_EQ(contradiction_in(*map), "");
  EXPECT_EQ(map->method, "orb");
  EXPECT_EQ(map->revision, 5);
  ASSERT_EQ(map->keyframes.size(), 5U);
  for (const Keyframe& keyframe : map->keyframes) {
    EXPECT_EQ(keyframe.frame, keyframe.id);
    EXPECT_EQ(keyframe.stamp, 100000000 * keyframe.id);
    EXPECT_EQ(keyframe.parent, bench.graph.keyframe(keyframe.id).parent);
    EXPECT_EQ(keyframe.submap, bench.graph.keyframe(keyframe.id).submap);
    EXPECT_THAT(keyframe.world_from_camera.inverse(),
                pose_near(bench.graph.camera_from_world(keyframe.id), 1e-12, 1e-12));
    EXPECT_EQ(map->layer<FeatureLayer>()->of.at(keyframe.id), bench.graph.keyframe(keyframe.id).frame->shared_data());
  }
  EXPECT_EQ(map->layer<FeatureLayer>()->extraction.features, 77);
  const auto landmarks = map->layer<LandmarkLayer>();
  ASSERT_EQ(landmarks->landmarks.size(), 2U) << "what nobody observes is left out";
  EXPECT_EQ(landmarks->landmarks[1].observations, bench.graph.landmark(1).observations);
  EXPECT_EQ(landmarks->landmarks[1].position, bench.graph.landmark(1).position);
  ASSERT_EQ(map->constraints.size(), 1U);
  EXPECT_EQ(map->constraints[0].inliers, 55);
  ASSERT_EQ(map->sessions.size(), 1U);
  EXPECT_EQ(map->sessions[0].first_stamp, 150);
  EXPECT_EQ(map->sessions[0].last_stamp, 250);
  EXPECT_EQ(map_of(empty_graph(), {}, std::nullopt)->sessions[0].last_stamp, 0);
}

TEST(MapExport, AContinuedMapKeepsItsSessions) {
  ExportBench bench;
  bench.track(1, 150, 0, SE3());
  bench.track(2, 250, 1, SE3());
  GivenMap given{MapScale{true, 0.5, "a known length"}, {}, {MapSession{0, 0, "first", 100, 300, {}}}};
  const auto map = map_of(bench.graph, bench.recorded, given);
  ASSERT_EQ(map->sessions.size(), 2U);
  EXPECT_EQ(map->sessions[0].recording, "first");
  EXPECT_EQ(map->sessions[1].session, 1);
  EXPECT_EQ(map->sessions[1].first_stamp, 150);
  EXPECT_EQ(map->sessions[1].last_stamp, 250);
  EXPECT_EQ(map->sessions[1].scale.origin, "a known length");
  EXPECT_EQ(map_of(bench.graph, {}, given)->sessions.size(), 1U) << "a run without a pose";
}

TEST(MapExport, TheScaleIsThatOfTheSensorUnlessOneIsGiven) {
  const auto exported = [](CameraKind sensor, const std::optional<MapScale>& scale) {
    return map_of(empty_graph(sensor), {}, scale ? std::optional(GivenMap{*scale, {}}) : std::nullopt);
  };
  const auto mono = exported(CameraKind::mono, std::nullopt), stereo = exported(CameraKind::stereo, std::nullopt),
             depth = exported(CameraKind::depth, std::nullopt);
  EXPECT_FALSE(mono->sessions[0].scale.metric);
  EXPECT_TRUE(stereo->sessions[0].scale.metric);
  EXPECT_TRUE(depth->sessions[0].scale.metric);
  EXPECT_EQ(mono->sessions[0].scale.origin, "arbitrary");
  EXPECT_EQ(stereo->sessions[0].scale.origin, "stereo baseline");
  EXPECT_EQ(depth->sessions[0].scale.origin, "depth camera");
  EXPECT_EQ(stereo->cameras[0].baseline, 0.1);
  EXPECT_EQ(depth->cameras[0].baseline, 0.0) << "a made-up one";
  EXPECT_EQ(exported(CameraKind::mono, MapScale{true, 0.01, "a known length"})->sessions[0].scale.relative_sigma, 0.01);
}

TEST(MapExport, TheSubmapWithMostFramesIsTheFirst) {
  ExportBench bench;
  bench.add(5, 2, -1);
  bench.track(1, 100, 2, SE3());
  const auto map = bench.map();
  KeyframeIds submaps;
  for (const Keyframe& keyframe : map->keyframes) submaps.push_back(keyframe.submap);
  EXPECT_EQ(submaps, (KeyframeIds{1, 1, 0, 0, 1, 2}));
}

TEST(MapExport, FramesAreInTheCurrentUnitOfTheirKeyframe) {
  ExportBench bench;
  bench.graph.keyframe(1).unit = 3.0;
  const SE3 motion(SO3::exp({0.0, 0.0, 0.5}), {1.0, 2.0, 4.0});
  bench.track(1, 100, 1, motion, 2.0);
  const auto map = bench.map();
  ASSERT_EQ(map->frames.size(), 1U);
  EXPECT_EQ(map->frames[0].stamp, 100);
  EXPECT_EQ(map->frames[0].keyframe, 1);
  EXPECT_THAT(map->frames[0].keyframe_from_camera.inverse(),
              pose_near(SE3(motion.rotation(), {1.5, 3.0, 6.0}), 1e-12, 1e-12));
}

TEST(MapExport, FramesOfACulledKeyframeReferToThePreviousOneOfTheirSubmap) {
  ExportBench bench;
  const SE3 motion(SO3(), {0.0, 0.0, 0.25});
  // Keyframe 1 was at 0.1 s; 2 and 3 belong to another submap.
  for (const TimeNs stamp : {TimeNs{-5}, TimeNs{0}, TimeNs{399999999}, TimeNs{400000000}})
    bench.track(bench.recorded.frames().empty() ? 0 : bench.recorded.frames().back().index + 1, stamp, 1, motion);
  bench.graph.remove_keyframe(1);
  const auto map = bench.map();
  ASSERT_EQ(map->frames.size(), 4U);
  KeyframeIds keyframes;
  for (const MapFrame& frame : map->frames) {
    keyframes.push_back(frame.keyframe);
    const SE3 pose = map->find(frame.keyframe)->world_from_camera * frame.keyframe_from_camera;
    EXPECT_THAT(pose.inverse(), pose_near(motion * camera_at(0.5), 1e-12, 1e-12));
  }
  EXPECT_EQ(keyframes, (KeyframeIds{0, 0, 0, 4})) << "the first where none is before";
}

TEST(MapExport, IsRestoredAsItWas) {
  const ExportBench bench;
  const auto map = bench.map();
  MapGraph graph = empty_graph();
  restore(*map, 0.1, graph);
  EXPECT_EQ(graph.keyframe_ids(), bench.graph.keyframe_ids());
  for (const std::int64_t id : graph.keyframe_ids()) {
    const MapKeyframe &now = graph.keyframe(id), &was = bench.graph.keyframe(id);
    EXPECT_THAT(now.camera_from_world, pose_near(was.camera_from_world, 1e-12, 1e-12));
    EXPECT_EQ(now.submap, was.submap);
    EXPECT_EQ(now.parent, was.parent);
    EXPECT_EQ(now.children, was.children);
    EXPECT_EQ(now.landmarks, was.landmarks);
    EXPECT_EQ(now.neighbors, was.neighbors);
    EXPECT_EQ(now.frame->right_pixel(7), was.frame->right_pixel(7));
  }
  EXPECT_EQ(graph.landmark_ids(), (KeyframeIds{0, 1}));
  for (const std::int64_t id : graph.landmark_ids()) {
    const MapLandmark &now = graph.landmark(id), &was = bench.graph.landmark(id);
    EXPECT_EQ(now.position, was.position);
    EXPECT_EQ(now.direction, was.direction);
    EXPECT_EQ(now.min_distance, was.min_distance);
    EXPECT_EQ(now.max_distance, was.max_distance);
    EXPECT_EQ(now.first_keyframe, 0);
  }
  ASSERT_EQ(graph.constraints().size(), 1U);
  EXPECT_EQ(graph.constraints()[0].from, 4);
}

TEST(MapExport, IdsTooFarApartForTheGraphAreRenumbered) {
  const ExportBench bench;
  Map map = *bench.map();
  constexpr KeyframeId most = 1 << 24;
  auto features = std::make_shared<FeatureLayer>(*map.layer<FeatureLayer>());
  auto landmarks = std::make_shared<LandmarkLayer>();
  features->of[most] = features->of.at(4);
  features->of.erase(4);
  map.keyframes[4].id = most;
  map.constraints.clear();
  map.layers.put<FeatureLayer>(features);
  map.layers.put<LandmarkLayer>(landmarks);
  MapGraph graph = empty_graph();
  restore(map, 0.1, graph);
  EXPECT_EQ(graph.keyframe_ids(), (KeyframeIds{0, 1, 2, 3, 4}));
  EXPECT_THAT(graph.camera_from_world(4), pose_near(camera_at(2.0), 1e-12, 1e-12));
}

TEST(MapExport, AContinuedMapKeepsItsSubmapItsScaleAndTheFramesOfEarlierRuns) {
  ExportBench first;
  const SE3 motion(SO3(), {0.1, 0.0, 0.0});
  first.track(7, 100, 0, motion);
  first.track(8, 200, 1, motion);
  auto map = std::make_shared<Map>(*first.map());
  map->sessions[0].scale = {true, 0.01, "a known length"};
  MapGraph graph = empty_graph();
  const GivenMap given = restore(*map, 0.1, graph);
  EXPECT_EQ(given.scale.relative_sigma, 0.01);
  // This run has all its frames in a new submap.
  FrameTrajectory now;
  graph.add_keyframe(blank_frame(9, 5.0, 0.1), camera_at(0.0), 2, -1);
  for (const std::int64_t index : {0, 1, 2}) now.add({index, 1000 + index, 9, 1.0, motion, -1, {}});
  const auto continued = map_of(graph, now, given);
  EXPECT_EQ(continued->keyframes.front().submap, 0);
  EXPECT_EQ(continued->keyframes.back().submap, 2);
  EXPECT_EQ(continued->sessions[0].scale.origin, "a known length");
  ASSERT_EQ(continued->frames.size(), 5U);
  EXPECT_EQ(continued->frames[1].stamp, 200);
  EXPECT_EQ(continued->frames[1].keyframe, 1);
  EXPECT_THAT(continued->frames[1].keyframe_from_camera, pose_near(motion.inverse(), 1e-12, 1e-12));
  EXPECT_EQ(continued->frames[2].stamp, 1000);
}

}  // namespace
}  // namespace rastro
