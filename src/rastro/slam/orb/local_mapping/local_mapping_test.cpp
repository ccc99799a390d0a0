// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/local_mapping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/local_mapping/mapping_testing.h"

namespace rastro {
namespace {

using testing::mapping_pose;
using testing::MappingBench;
using testing::Observed;
using testing::pose_near;
using testing::without_keyframe_culling;

/// Two frames and an initializer's result for them: pairs of features and points with `error`.
struct MappingStart {
  MappingStart(MappingBench& bench, double error)
      : first(bench.observe(0, SE3())), second(bench.observe(1, mapping_pose(1))) {
    Random random(4);
    for (std::uint32_t i = 0; i < first.seen.size(); ++i) {
      const auto k = std::find(second.seen.begin(), second.seen.end(), first.seen[i]);
      if (k == second.seen.end()) continue;
      pairs.emplace_back(i, static_cast<std::uint32_t>(k - second.seen.begin()));
      points.emplace_back(bench.world.points[first.seen[i]] * (1.0 + error * random.uniform(-1.0, 1.0)));
    }
  }
  Observed first, second;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  std::vector<std::optional<Eigen::Vector3d>> points;
};

/// Landmarks of an exact initialization.
std::vector<std::int64_t> start_exactly(MappingBench& bench) {
  const MappingStart start(bench, 0.0);
  EXPECT_TRUE(
      bench.mapping.initialize(start.first.frame, start.second.frame, mapping_pose(1), start.pairs, start.points, 0));
  const std::vector<std::int64_t> ids = bench.map.graph.landmark_ids();
  EXPECT_EQ(ids.size(), start.pairs.size());
  for (std::size_t i = 0; i < ids.size(); ++i) bench.map.landmark_of[start.first.seen[start.pairs[i].first]] = ids[i];
  return ids;
}

TEST(LocalMapping, AnInitialMapIsAdjustedAndScaledToAMedianDepthOfOne) {
  MappingBench bench(CameraKind::mono);
  MappingStart start(bench, 0.02);
  start.points[3] = std::nullopt;
  const SE3 rough = SE3(SO3::exp({0.002, -0.001, 0.002}), {0.01, 0.005, -0.01}) * mapping_pose(1);
  ASSERT_TRUE(bench.mapping.initialize(start.first.frame, start.second.frame, rough, start.pairs, start.points, 0));
  const MapGraph& graph = bench.map.graph;
  EXPECT_EQ(graph.landmark_count(), start.pairs.size() - 1);
  EXPECT_THAT(graph.camera_from_world(0), pose_near(SE3(), 0.0, 0.0));
  std::vector<double> depths;
  for (const std::int64_t id : graph.landmark_ids()) depths.push_back(graph.landmark(id).position.z());
  std::sort(depths.begin(), depths.end());
  EXPECT_DOUBLE_EQ(depths[depths.size() / 2], 1.0);
  const double scale = bench.scale();
  EXPECT_THAT(graph.camera_from_world(1),
              pose_near(SE3(mapping_pose(1).rotation(), scale * mapping_pose(1).translation()), 1e-4, 1e-4));
  EXPECT_EQ(bench.true_landmarks(2e-3, scale), graph.landmark_count());
  for (const int id : {0, 1}) EXPECT_EQ(graph.unit(id), 1.0);
}

TEST(LocalMapping, AnInitialMapWithTooFewPointsLeavesNothing) {
  MappingBench bench(CameraKind::mono);
  MappingStart start(bench, 0.0);
  for (std::size_t i = 49; i < start.points.size(); ++i) start.points[i] = std::nullopt;
  EXPECT_FALSE(
      bench.mapping.initialize(start.first.frame, start.second.frame, mapping_pose(1), start.pairs, start.points, 0));
  EXPECT_EQ(bench.map.graph.keyframe_count(), 0U);
  EXPECT_EQ(bench.map.graph.landmark_count(), 0U);
}

TEST(LocalMapping, DepthInitializesWithEveryPointThatIsNearEnough) {
  OrbSlamOptions options;
  options.far_baselines = 80.0;  // 8 m
  MappingBench bench(CameraKind::depth, options);
  const Observed first = bench.observe(0, SE3());
  bench.mapping.initialize(first.frame, 0);
  std::size_t near = 0;
  for (const std::uint32_t point : first.seen) near += bench.world.points[point].z() <= 8.0;
  EXPECT_GT(near, 50U);
  EXPECT_LT(near, first.seen.size() - 50);
  EXPECT_EQ(bench.map.graph.landmark_count(), near);
  EXPECT_EQ(bench.true_landmarks(1e-5), near);
  EXPECT_EQ(bench.map.graph.keyframe(0).parent, -1) << "a root";
}

TEST(LocalMapping, NewPointsOfTwoKeyframesAreTriangulated) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    OrbSlamOptions options;
    options.far_baselines = 30.0;  // of points with depth, none is nearer than 3 m
    MappingBench bench(sensor, options);
    // Both keyframes observe all points, but have landmarks of the first half only.
    for (const int id : {0, 1}) bench.add_keyframe(id);
    bench.forget_second_half();
    EXPECT_EQ(bench.true_landmarks(1e-9), 100U);
    bench.mapping.process(bench.input(2, 1));
    EXPECT_GT(bench.map.graph.landmark_count(), 195U);
    EXPECT_EQ(bench.true_landmarks(1e-3), bench.map.graph.landmark_count());
    // Fusion adds the third observation of a new point.
    std::size_t complete = 0;
    for (const std::int64_t id : bench.map.graph.landmark_ids())
      complete += bench.map.graph.landmark(id).observations.size() == 3;
    EXPECT_GT(complete, 190U);
    EXPECT_THAT(bench.map.graph.camera_from_world(2), pose_near(mapping_pose(2), 1e-3, 1e-4));
  }
}

TEST(LocalMapping, EveryFeatureWithoutALandmarkIsTriangulated) {
  MappingBench bench(CameraKind::mono, without_keyframe_culling());
  for (const int id : {0, 1}) bench.add_keyframe(id);
  const auto landmark_of_feature = [&](std::uint32_t feature) {
    return bench.map.graph.keyframe(1).landmarks[feature];
  };
  const auto last = static_cast<std::uint32_t>(bench.seen[1].size()) - 1;
  for (const std::uint32_t feature : {0U, 1U, last}) {
    bench.map.landmark_of[bench.seen[1][feature]] = -1;
    bench.map.graph.remove_landmark(landmark_of_feature(feature));
  }
  bench.mapping.process(bench.input(2, 1));
  for (const std::uint32_t feature : {0U, 1U, last}) EXPECT_GE(landmark_of_feature(feature), 0) << feature;
  EXPECT_EQ(bench.true_landmarks(1e-3), bench.map.graph.landmark_count());
}

TEST(LocalMapping, NothingIsTriangulatedFromOnePosition) {
  MappingBench bench(CameraKind::mono);
  const SE3 beside(SO3::exp({0.0, 0.02, 0.0}), {-0.02, 0.0, 0.0});
  bench.map.add(0, SE3());
  bench.map.add(1, beside);
  bench.forget_second_half();
  const Observed all = bench.observe(2, beside);
  bench.mapping.process({all.frame, 0, beside, 1.0, bench.map.tracked(all), {}});
  EXPECT_EQ(bench.map.graph.landmark_count(), 100U);
}

TEST(LocalMapping, LandmarksThatAreSeldomFoundAreCulled) {
  MappingBench bench(CameraKind::mono, without_keyframe_culling());
  const std::vector<std::int64_t> ids = start_exactly(bench);
  // Found once when created; a quarter of the frames that should observe it are enough.
  KeyframeInput input = bench.input(2, 1);
  input.counts = {{ids[0], {4, 0}}, {ids[1], {3, 0}}, {ids[2], {4, 1}}};
  bench.mapping.process(input);
  EXPECT_FALSE(bench.map.graph.has_landmark(ids[0]));
  EXPECT_TRUE(bench.map.graph.has_landmark(ids[1]));
  EXPECT_TRUE(bench.map.graph.has_landmark(ids[2]));
}

TEST(LocalMapping, LandmarksNotObservedByTheSecondKeyframeAfterAreCulled) {
  MappingBench bench(CameraKind::mono, without_keyframe_culling());
  start_exactly(bench);
  bench.mapping.process(bench.input(2, 1, {.from = 0, .to = 150}));
  for (std::size_t point = 0; point < 200; ++point)
    EXPECT_EQ(bench.map.graph.has_landmark(bench.map.landmark_of[point]), point < 150) << point;
}

TEST(LocalMapping, TwoLandmarksOfOnePointBecomeOne) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    MappingBench bench(sensor, without_keyframe_culling());
    for (const int id : {0, 1}) bench.add_keyframe(id);
    const std::vector<std::int64_t> old = bench.map.landmark_of;
    // The next two keyframes create new landmarks for a quarter of the points.
    std::fill_n(bench.map.landmark_of.begin(), 50, -1);
    for (const int id : {2, 3}) bench.add_keyframe(id);
    EXPECT_EQ(bench.map.graph.landmark_count(), 250U);
    KeyframeInput input = bench.input(4, 3);
    std::erase_if(input.points, [](const TrackedPoint& point) { return point.landmark < 100; });
    bench.mapping.process(input);
    const MapKeyframe& newest = bench.map.graph.keyframe(4);
    EXPECT_EQ(std::count(newest.landmarks.begin(), newest.landmarks.end(), -1), 0) << "what tracking missed is found";
    EXPECT_EQ(bench.map.graph.landmark_count(), 200U);
    EXPECT_EQ(bench.true_landmarks(1e-3), 200U);
    for (std::size_t point = 0; point < 50; ++point) {
      const std::int64_t kept = bench.map.graph.current(old[point]);
      EXPECT_EQ(kept, bench.map.landmark_of[point]) << "what more keyframes see stays";
      EXPECT_EQ(bench.map.graph.landmark(kept).observations.size(), 5U);
    }
  }
}

TEST(LocalMapping, ARedundantKeyframeIsCulledUnlessItHasALoop) {
  for (const bool has_loop : {false, true}) {
    MappingBench bench(CameraKind::mono);
    for (int id = 0; id < 5; ++id) bench.add_keyframe(id);
    if (has_loop)
      bench.map.graph.constraints() = {{.from = 1, .to = 2, .from_from_to = {}, .inliers = 9},
                                       {.from = 1, .to = 3, .from_from_to = {}, .inliers = 9}};
    bench.mapping.process(bench.input(5, 4));
    // The first anchors the map, the last two may still get observations.
    using Ids = std::vector<std::int64_t>;
    EXPECT_EQ(bench.map.graph.keyframe_ids(), has_loop ? (Ids{0, 1, 2, 3, 4, 5}) : (Ids{0, 4, 5}));
    EXPECT_THAT(bench.map.graph.camera_from_world(2), pose_near(mapping_pose(2), 1e-3, 1e-4));
  }
}

TEST(LocalMapping, AdjustingRemovesOutliers) {
  MappingBench bench(CameraKind::depth, without_keyframe_culling());
  for (int id = 0; id < 4; ++id) bench.add_keyframe(id);
  bench.map.graph.make_root(1);
  bench.mapping.process(bench.input(4, 3, {.moved_share = 0.2}));
  EXPECT_EQ(bench.map.graph.camera_from_world(1).matrix(), mapping_pose(1).matrix()) << "the root holds the map";
  const MapKeyframe& keyframe = bench.map.graph.keyframe(4);
  std::size_t moved = 0;
  for (std::uint32_t i = 0; i < keyframe.landmarks.size(); ++i) {
    const Eigen::Vector3d p = mapping_pose(4) * bench.world.points[bench.seen[4][i]];
    const bool fits = (*bench.world.camera.project(p) - keyframe.frame->pixel(i).cast<double>()).norm() < 1.0;
    moved += !fits;
    EXPECT_EQ(keyframe.landmarks[i] >= 0, fits) << i;
  }
  EXPECT_GT(moved, 20U);
  EXPECT_THAT(keyframe.camera_from_world, pose_near(mapping_pose(4), 1e-3, 1e-4));
}

TEST(LocalMapping, AWholeSubmapIsAdjustedAboutItsRoot) {
  MappingBench bench(CameraKind::depth);
  for (int id = 0; id < 4; ++id) bench.add_keyframe(id);
  MapGraph& graph = bench.map.graph;
  Random random(3);
  for (int id = 1; id < 4; ++id)
    graph.keyframe(id).camera_from_world = SE3::exp(testing::random_vector<Vector6d>(random, 0.01)) * mapping_pose(id);
  for (const std::int64_t id : graph.landmark_ids())
    graph.landmark(id).position += testing::random_vector<Eigen::Vector3d>(random, 0.05);
  bench.mapping.adjust_all(0, 20);
  EXPECT_THAT(graph.camera_from_world(0), pose_near(SE3(), 0.0, 0.0));
  for (int id = 1; id < 4; ++id)
    EXPECT_THAT(graph.camera_from_world(id), pose_near(mapping_pose(id), 1e-3, 1e-4)) << id;
  EXPECT_EQ(bench.true_landmarks(1e-3), 200U);
}

TEST(LocalMapping, AKeyframesParentSharesMostAndItsPoseIsInTheCurrentUnit) {
  MappingBench bench(CameraKind::mono);
  bench.add_keyframe(0, {.from = 0, .to = 150});
  bench.add_keyframe(1, {.from = 0, .to = 50});
  // Nothing connects it to the map: it keeps its pose, in the unit of the reference.
  KeyframeInput disconnected = bench.input(2, 1);
  disconnected.points.clear();
  disconnected.camera_from_reference = SE3(SO3::exp({0.0, 0.2, 0.0}), {1.0, 2.0, 3.0});
  disconnected.reference_unit = 0.5;
  bench.mapping.process(disconnected);
  const SE3 doubled(SO3::exp({0.0, 0.2, 0.0}), {2.0, 4.0, 6.0});
  EXPECT_THAT(bench.map.graph.camera_from_world(2), pose_near(doubled * mapping_pose(1), 1e-9, 1e-9));
  EXPECT_EQ(bench.map.graph.keyframe(2).parent, 1);
  bench.mapping.process(bench.input(3, 1));
  EXPECT_EQ(bench.map.graph.keyframe(3).parent, 0);
}

TEST(LocalMapping, OnlyTheRootIsHeldNotItsChildren) {
  MappingBench bench(CameraKind::depth, without_keyframe_culling());
  for (int id = 0; id < 3; ++id) bench.add_keyframe(id);
  MapGraph& graph = bench.map.graph;
  ASSERT_EQ(graph.keyframe(1).parent, 0);
  graph.keyframe(1).camera_from_world = SE3(SO3(), {0.0, 0.03, 0.0}) * mapping_pose(1);
  bench.mapping.process(bench.input(3, 2));
  EXPECT_THAT(graph.camera_from_world(1), pose_near(mapping_pose(1), 5e-3, 1e-3));
}

}  // namespace
}  // namespace rastro
