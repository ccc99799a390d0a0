// SPDX-License-Identifier: Apache-2.0
// That mapping does not depend on the map's unit, which of two landmarks stays, and how often a start is adjusted.
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

TEST(LocalMapping, TheUnitOfAMapIsArbitrary) {
  for (const double scale : {0.02, 50.0}) {
    MappingBench bench(CameraKind::mono, without_keyframe_culling());
    for (const int id : {0, 1}) bench.add_keyframe(id);
    bench.forget_second_half();
    bench.map.graph.transform(0, Sim3(scale, SO3(), Eigen::Vector3d::Zero()));
    KeyframeInput input = bench.input(2, 1);
    input.reference_unit = bench.map.graph.unit(1);
    bench.mapping.process(input);
    EXPECT_GT(bench.map.graph.landmark_count(), 195U) << scale;
    EXPECT_EQ(bench.true_landmarks(1e-3, scale), bench.map.graph.landmark_count()) << scale;
    const SE3 expected(mapping_pose(2).rotation(), scale * mapping_pose(2).translation());
    EXPECT_THAT(bench.map.graph.camera_from_world(2), pose_near(expected, 1e-3 * scale, 1e-4)) << scale;
  }
}

/// Points 0 to 49 have an old landmark in the first `of_old` keyframes and a newer one in the next `of_newer`; the last
/// keyframe tracks the newer.
TEST(LocalMapping, OfTwoLandmarksTheOneWithMoreObservationsStaysThenTheOlder) {
  for (const auto& [of_old, of_newer] : {std::pair{2, 1}, {2, 2}, {3, 2}, {4, 2}}) {
    MappingBench bench(CameraKind::mono, without_keyframe_culling());
    for (int id = 0; id < of_old; ++id) bench.add_keyframe(id);
    const std::vector<std::int64_t> old = bench.map.landmark_of;
    std::fill_n(bench.map.landmark_of.begin(), 50, -1);
    const int last = of_old + of_newer;
    for (int id = of_old; id < last; ++id) bench.add_keyframe(id);
    const std::vector<std::int64_t> newer = bench.map.landmark_of;
    bench.mapping.process(bench.input(last, last - 1));
    const bool old_stays = of_old >= of_newer + 1;
    for (std::size_t point = 0; point < 50; ++point) {
      const std::int64_t kept = bench.map.graph.current(newer[point]);
      EXPECT_EQ(kept, old_stays ? old[point] : newer[point]) << of_old << ' ' << of_newer;
      EXPECT_EQ(bench.map.graph.current(old[point]), kept);
    }
  }
}

/// The rotation of the second keyframe: after a start with `adjust_iterations`, or as adjusted that often (0: not).
SO3 started(int adjust_iterations, int adjusted) {
  OrbSlamOptions options;
  options.adjust_iterations = adjust_iterations;
  MappingBench bench(CameraKind::mono, options);
  const auto first = bench.observe(0, SE3()), second = bench.observe(1, mapping_pose(1));
  const SE3 rough = SE3(SO3::exp({0.003, -0.002, 0.004}), {0.03, 0.02, -0.03}) * mapping_pose(1);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  std::vector<std::optional<Eigen::Vector3d>> points;
  Random random(4);
  for (std::uint32_t i = 0; i < first.seen.size(); ++i) {
    const auto k = std::find(second.seen.begin(), second.seen.end(), first.seen[i]);
    if (k == second.seen.end()) continue;
    pairs.emplace_back(i, static_cast<std::uint32_t>(k - second.seen.begin()));
    points.emplace_back(bench.world.points[first.seen[i]] * (1.0 + 0.02 * random.uniform(-1.0, 1.0)));
  }
  MapGraph& graph = bench.map.graph;
  if (adjusted == 0) {
    EXPECT_TRUE(bench.mapping.initialize(first.frame, second.frame, rough, pairs, points, 0));
  } else {
    graph.add_keyframe(first.frame, SE3(), 0, -1);
    graph.add_keyframe(second.frame, rough, 0, 0);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const std::int64_t id = graph.add_landmark(*points[i], 0).id;
      graph.add_observation(0, pairs[i].first, id);
      graph.add_observation(1, pairs[i].second, id);
    }
    bench.mapping.adjust_all(0, adjusted);
  }
  return graph.camera_from_world(1).rotation();
}

TEST(LocalMapping, AStartIsAdjustedTwiceAsOftenAsAKeyframe) {
  const SO3 made = started(1, 0);
  const auto off = [&](int adjusted) { return (made.inverse() * started(1, adjusted)).log().norm(); };
  EXPECT_LT(off(2), 1e-14);
  for (const int other : {1, 3, 4}) EXPECT_GT(off(other), 1e-8) << other;
}

}  // namespace
}  // namespace rastro
