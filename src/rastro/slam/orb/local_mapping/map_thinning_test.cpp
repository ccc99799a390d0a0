// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/map_thinning.h"

#include <gtest/gtest.h>

#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::PointWorld;
using IdsLeft = std::vector<std::int64_t>;

/// Keyframes 0.05 m apart that all observe the same points.
struct ThinningBench {
  explicit ThinningBench(int keyframes, CameraKind sensor = CameraKind::mono)
      : map(world, sensor, sensor == CameraKind::mono ? 0.0 : 0.1) {
    for (int k = 0; k < keyframes; ++k) add(k);
  }
  void add(std::int64_t id) { map.add(id, SE3(SO3(), {-0.05 * static_cast<double>(id), 0.0, 0.0})); }
  std::size_t bytes() { return MapThinning(options, map.graph, 1).memory(0).bytes; }
  /// The keyframes that are left with a budget of `share` of the map.
  IdsLeft left(double share) {
    MapThinning thinning(options, map.graph, static_cast<std::size_t>(share * static_cast<double>(bytes())));
    thinning.process(0, events);
    return map.graph.keyframe_ids();
  }

  PointWorld world{200, 3};
  ExactMap map;
  OrbSlamOptions options;
  std::vector<SlamEvent> events;
};

TEST(MapThinning, TheMemoryGrowsWithFeaturesObservationsKeyframesAndConstraints) {
  ThinningBench one(1), two(2), many(8);
  const std::size_t first = one.bytes(), second = two.bytes() - first;
  EXPECT_GT(second, sizeof(MapKeyframe));
  EXPECT_LT(second, first) << "its landmarks are those of the first";
  EXPECT_GT(first, second + one.map.graph.landmark_count() * sizeof(MapLandmark) / 2);
  const auto features = static_cast<double>(one.map.graph.keyframe(0).landmarks.size());
  EXPECT_NEAR(static_cast<double>(many.bytes()) - static_cast<double>(first), 7.0 * static_cast<double>(second),
              8.0 * 8.0 * sizeof(Neighbor) + 0.03 * 7.0 * features * 100.0);
  EXPECT_GT(static_cast<double>(second),
            features * static_cast<double>(sizeof(Descriptor) + sizeof(Keypoint) + sizeof(LandmarkObservation)));
  EXPECT_LT(static_cast<double>(second), features * 150.0 + sizeof(MapKeyframe) + 100.0);
  const std::size_t before = many.bytes();
  many.map.graph.constraints() = {{.from = 0, .to = 7, .from_from_to = {}, .inliers = 9}};
  EXPECT_EQ(many.bytes(), before + sizeof(Constraint));
  EXPECT_EQ(MapThinning(many.options, many.map.graph, 1).memory(1000).bytes, before + sizeof(Constraint) + 1000);
}

/// 41 bytes of a feature's own beside keypoint and descriptor: depth, level, pixel, grid, landmark and word.
TEST(MapThinning, TheMemoryIsThatOfItsPartsOneByOne) {
  ThinningBench bench(5);
  bench.map.graph.constraints().resize(3);
  std::size_t features = 0, neighbors = 0, observations = 0;
  for (const std::int64_t id : bench.map.graph.keyframe_ids()) {
    features += bench.map.graph.keyframe(id).frame->size();
    neighbors += bench.map.graph.keyframe(id).neighbors.size();
  }
  for (const std::int64_t id : bench.map.graph.landmark_ids())
    observations += bench.map.graph.landmark(id).observations.size();
  const std::size_t expected = 5 * sizeof(MapKeyframe) + features * (sizeof(Keypoint) + sizeof(Descriptor) + 41) +
                               neighbors * sizeof(Neighbor) + observations * sizeof(LandmarkObservation) +
                               bench.map.graph.landmark_count() * sizeof(MapLandmark) + 3 * sizeof(Constraint);
  EXPECT_EQ(neighbors, 20U) << "each has the four others";
  EXPECT_EQ(bench.bytes(), expected);
}

TEST(MapThinning, WithoutALimitNothingHappens) {
  ThinningBench bench(15);
  MapThinning thinning(bench.options, bench.map.graph, 0);
  thinning.process(1000000000, bench.events);
  EXPECT_EQ(bench.map.graph.keyframe_count(), 15U);
  EXPECT_TRUE(bench.events.empty());
}

TEST(MapThinning, RedundantKeyframesGoFromNineTenthsOnUntilTheMapFits) {
  ThinningBench below(20), above(20);
  EXPECT_EQ(below.left(1.2).size(), 20U) << "83 % of the budget";
  ASSERT_EQ(below.events.size(), 1U) << "a stage begins";
  EXPECT_EQ(below.events[0].detail.substr(0, 22), "the map uses 83 % of i");
  EXPECT_NE(below.events[0].detail.find("2 times as sparse, no observations of frames"), std::string::npos)
      << below.events[0].detail;
  ThinningBench half(20);
  half.left(1.6);
  ASSERT_EQ(half.events.size(), 1U);
  EXPECT_NE(half.events[0].detail.find("1.5 times as sparse"), std::string::npos) << half.events[0].detail;
  EXPECT_EQ(half.events[0].detail.find("no observations of frames"), std::string::npos) << half.events[0].detail;
  const IdsLeft left = above.left(1.0);
  EXPECT_LT(left.size(), 20U);
  EXPECT_GT(left.size(), 15U) << "no more than needed";
  ASSERT_EQ(above.events.size(), 1U);
  EXPECT_NE(above.events[0].detail.find(" keyframes removed"), std::string::npos) << above.events[0].detail;
}

TEST(MapThinning, TheRootLoopsAndTheNewestTenStay) {
  ThinningBench bench(20);
  bench.map.graph.constraints() = {{.from = 3, .to = 5, .from_from_to = {}, .inliers = 9}};
  EXPECT_EQ(bench.left(0.05), (IdsLeft{0, 3, 5, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19}));
}

TEST(MapThinning, TheTrajectoryCounts) {
  ThinningBench bench(20);
  MapThinning thinning(bench.options, bench.map.graph, 2 * bench.bytes());
  thinning.process(bench.bytes() / 2, bench.events);
  EXPECT_EQ(bench.map.graph.keyframe_count(), 20U);
  thinning.process(bench.bytes(), bench.events);
  EXPECT_LT(bench.map.graph.keyframe_count(), 20U);
}

/// Every keyframe observes every seventh point, and only those seven before and after it observe the same.
TEST(MapThinning, KeyframesThatAreNotRedundantStayUntilTheBudgetIsExceeded) {
  ThinningBench full(20), beyond(20);
  for (ThinningBench* bench : {&full, &beyond}) {
    for (std::int64_t id = 0; id < 20; ++id) {
      const IdsLeft landmarks = bench->map.graph.keyframe(id).landmarks;
      for (const std::int64_t landmark : landmarks) {
        if (landmark >= 0 && landmark % 7 != id % 7) bench->map.graph.remove_observation(id, landmark);
      }
    }
  }
  // Each landmark now has two or three observations: nothing is redundant.
  ASSERT_EQ(redundancy_of(full.map.graph, full.map.graph.keyframe(4), full.options).redundant, 0);
  MapThinning thinning(full.options, full.map.graph, full.bytes() * 51 / 50);
  for (int k = 0; k < 2; ++k) thinning.process(0, full.events);
  EXPECT_EQ(full.map.graph.keyframe_count(), 20U) << "98 %";
  EXPECT_EQ(full.events.size(), 1U) << "nothing new happened the second time";
  EXPECT_LT(beyond.left(0.95).size(), 20U);
}

}  // namespace
}  // namespace rastro
