// SPDX-License-Identifier: Apache-2.0
// Which keyframes a new one is connected to, adjusted with and triangulated against.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/local_mapping/mapping_testing.h"

namespace rastro {
namespace {

using testing::mapping_pose;
using testing::MappingBench;
using testing::pose_near;
using testing::without_keyframe_culling;

/// A keyframe that observes no landmark, relative to the second of four keyframes.
std::int64_t parent_of_unconnected(bool reference_removed) {
  MappingBench bench(CameraKind::mono, without_keyframe_culling());
  for (const int id : {0, 1, 2, 3}) bench.add_keyframe(id);
  KeyframeInput input = bench.input(4, 1);
  input.points.clear();
  if (reference_removed) bench.map.graph.remove_keyframe(1);
  // Where nothing is in view.
  input.camera_from_reference = SE3(SO3::exp({0.0, 3.0, 0.0}), {1.0, 2.0, 3.0});
  const SE3 expected = input.camera_from_reference * bench.map.graph.camera_from_world(1);
  bench.mapping.process(input);
  EXPECT_THAT(bench.map.graph.camera_from_world(4), pose_near(expected, 1e-9, 1e-9));
  return bench.map.graph.keyframe(4).parent;
}

TEST(MappingLimits, TheParentIsTheReferenceOrTheNewestKeyframeWhereThatIsGone) {
  EXPECT_EQ(parent_of_unconnected(false), 1);
  EXPECT_EQ(parent_of_unconnected(true), 3);
}

TEST(MappingLimits, PointsOfAKeyframesFeaturesAreItsLandmarksByNow) {
  MappingBench bench(CameraKind::depth, without_keyframe_culling());
  for (const int id : {0, 1}) bench.add_keyframe(id);
  KeyframeInput input = bench.input(2, 1);
  ASSERT_GT(input.points.size(), 100U);
  input.points.resize(40);
  std::vector<std::int64_t> expected;
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    TrackedPoint& point = input.points[i];
    expected.push_back(point.landmark);
    if (i % 4 == 0) continue;
    const auto& seen = bench.map.graph.keyframe(1).landmarks;
    point.keyframe_feature =
        static_cast<std::uint32_t>(std::find(seen.begin(), seen.end(), point.landmark) - seen.begin());
    point.keyframe = i % 4 == 1 ? 1 : i % 4 == 2 ? 77 : -1;  // one that is there, one that is not, and none
    point.landmark = -1;
    if (i % 4 > 1) expected.back() = -1;
  }
  OrbSlamOptions options = without_keyframe_culling();
  // Nothing is added to what was tracked.
  options.max_view_angle_deg = 0.0;
  options.far_baselines = 0.0;
  LocalMapping(options, bench.map.graph, nullptr).process(input);
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(bench.map.graph.keyframe(2).landmarks[input.points[i].feature], expected[i]) << i;
}

/// Landmarks that a keyframe adds to those of two keyframes in one place, beside which it is at `baseline`.
std::size_t triangulated_from(CameraKind sensor, double baseline) {
  OrbSlamOptions options = without_keyframe_culling();
  options.triangulate_parallax_deg = 0.0;
  options.far_baselines = 0.1;
  MappingBench bench(sensor, options);
  for (const int id : {0, 1}) bench.map.add(id, SE3());
  bench.forget_second_half();
  const SE3 beside(SO3(), {-baseline, 0.0, 0.0});
  const auto all = bench.observe(2, beside);
  bench.mapping.process({all.frame, 0, beside, 1.0, bench.map.tracked(all), {}});
  return bench.map.graph.landmark_count() - 100;
}

TEST(MappingLimits, TheBaselineIsAHundredthOfTheDepthOrThatOfTheSensor) {
  std::vector<double> depths;
  for (const Eigen::Vector3d& point : testing::PointWorld(200, 11).points) {
    if (depths.size() < 100) depths.push_back(point.z());
  }
  std::sort(depths.begin(), depths.end());
  for (const auto& [sensor, least] : {std::pair{CameraKind::mono, 0.01 * depths[50]}, {CameraKind::depth, 0.1}}) {
    EXPECT_EQ(triangulated_from(sensor, 0.99 * least), 0U);
    EXPECT_GT(triangulated_from(sensor, 1.01 * least), 80U);
  }
  EXPECT_GT(triangulated_from(CameraKind::depth, 0.1), 80U) << "that of the sensor is enough";
}

/// The share of the points without landmarks that are triangulated if their descriptors differ by so many bits.
std::size_t triangulated_with_bits(int bits) {
  MappingBench bench(CameraKind::mono, without_keyframe_culling());
  for (const int id : {0, 1}) bench.add_keyframe(id);
  bench.forget_second_half();
  KeyframeInput input = bench.input(2, 1);
  auto data = std::make_shared<ImageFeatures>(input.frame->data());
  for (Descriptor& descriptor : data->features.descriptors)
    for (int k = 0; k < bits; ++k) descriptor.words[static_cast<std::size_t>(k % 4)] ^= std::uint64_t{1} << (k / 4);
  input.frame = std::make_shared<FeatureFrame>(std::move(data), bench.world.camera, 0.0);
  bench.mapping.process(input);
  return bench.map.graph.landmark_count() - 100;
}

TEST(MappingLimits, PartnersMayDifferInAsManyBitsAsTheOptionSays) {
  const int most = OrbSlamOptions{}.triangulate_hamming;
  EXPECT_GT(triangulated_with_bits(most), 80U);
  EXPECT_EQ(triangulated_with_bits(most + 1), 0U);
}

/// By keyframe: landmarks of the new keyframe that are fused into it, and those it shares with the last but one.
struct SecondNeighbors {
  std::vector<int> fused, shared;
};

/// Keyframes 0 to 5 lack landmarks of the points from 100 to 140, which the last two have. Each shares fewer landmarks
/// with the last but one, and none with the last.
SecondNeighbors fused_into_second_neighbors(int covisible_landmarks) {
  OrbSlamOptions options = without_keyframe_culling();
  options.covisible_landmarks = covisible_landmarks;
  MappingBench bench(CameraKind::depth, options);
  const MapGraph& graph = bench.map.graph;
  for (int id = 0; id < 6; ++id) bench.add_keyframe(id, {.from = static_cast<std::uint32_t>(20 + 5 * id), .to = 140});
  for (std::size_t point = 100; point < 140; ++point) {
    bench.map.graph.remove_landmark(bench.map.landmark_of[point]);
    bench.map.landmark_of[point] = -1;
  }
  bench.add_keyframe(6, {.from = 20, .to = 200});
  SecondNeighbors result;
  for (int id = 0; id < 6; ++id) result.shared.push_back(graph.shared(id, 6));
  bench.mapping.process(bench.input(7, 6, {.from = 100, .to = 200}));
  for (int id = 0; id < 6; ++id) {
    const auto& landmarks = graph.keyframe(id).landmarks;
    result.fused.push_back(
        static_cast<int>(std::count_if(landmarks.begin(), landmarks.end(), [&](std::int64_t landmark) {
          return landmark >= 0 && graph.feature_of(7, landmark) >= 0;
        })));
  }
  return result;
}

TEST(MappingLimits, LandmarksAreFusedIntoTheNeighborsOfANeighborThatShareEnough) {
  using ::testing::ElementsAre;
  const auto most = ::testing::Gt(35);
  const SecondNeighbors by_number = fused_into_second_neighbors(15);
  EXPECT_THAT(by_number.fused, ElementsAre(most, most, most, most, 0, 0)) << "the new one is the first of five";
  const int shared = by_number.shared[2];
  EXPECT_THAT(fused_into_second_neighbors(shared).fused, ElementsAre(most, most, most, 0, 0, 0));
  EXPECT_THAT(fused_into_second_neighbors(shared + 1).fused, ElementsAre(most, most, 0, 0, 0, 0));
}

TEST(MappingLimits, WithoutTheRootTheOldestAdjustedKeyframeIsHeld) {
  MappingBench bench(CameraKind::depth, without_keyframe_culling());
  bench.add_keyframe(0, {.from = 0, .to = 50});
  for (const int id : {1, 2}) bench.add_keyframe(id, {.from = 60, .to = 200});
  MapGraph& graph = bench.map.graph;
  graph.keyframe(2).camera_from_world = SE3(SO3(), {0.0, 0.02, 0.0}) * mapping_pose(2);
  bench.mapping.process(bench.input(3, 1, {.from = 60, .to = 200}));
  EXPECT_EQ(graph.camera_from_world(1).matrix(), mapping_pose(1).matrix());
  for (const int id : {2, 3}) EXPECT_THAT(graph.camera_from_world(id), pose_near(mapping_pose(id), 2e-3, 1e-3)) << id;
}

/// With one keyframe free beside the new one, the pose of the new one where keyframes are held: of the others, number 2
/// shares most with both and is where it is, and number 0 is not.
SE3 adjusted_with(int held) {
  OrbSlamOptions options = without_keyframe_culling();
  options.adjust_keyframes = 1;
  options.adjust_fixed = held;
  MappingBench bench(CameraKind::depth, options);
  bench.add_keyframe(0, {.from = 0, .to = 100});
  bench.add_keyframe(1, {.from = 0, .to = 200});
  bench.add_keyframe(2, {.from = 0, .to = 150});
  bench.map.graph.keyframe(0).camera_from_world = SE3(SO3(), {0.0, 0.05, 0.0});
  bench.mapping.process(bench.input(3, 1));
  return bench.map.graph.camera_from_world(3);
}

TEST(MappingLimits, OnlyTheKeyframesThatShareMostAreHeldWhileAdjusting) {
  EXPECT_THAT(adjusted_with(1), pose_near(mapping_pose(3), 1e-4, 1e-5));
  EXPECT_THAT(adjusted_with(2), ::testing::Not(pose_near(mapping_pose(3), 1e-3, 1e-4)));
}

}  // namespace
}  // namespace rastro
