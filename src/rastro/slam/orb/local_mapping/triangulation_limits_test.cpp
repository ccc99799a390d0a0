// SPDX-License-Identifier: Apache-2.0
// Which pairs of features are one point.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "rastro/slam/orb/local_mapping/mapping_testing.h"

namespace rastro {
namespace {

using testing::MappingBench;

/// Changes a feature's position, pixels, or level.
using Change = std::function<void(Keypoint&, std::uint8_t&)>;

/// The share of the points without a landmark that become one with a third keyframe, whose features of them are
/// changed; of those with at least `least_level`, at most `most_level`.
double share_triangulated(const Change& change, int least_level, int most_level) {
  MappingBench bench(CameraKind::mono, testing::without_keyframe_culling());
  for (const int id : {0, 1}) bench.add_keyframe(id);
  bench.forget_second_half();
  KeyframeInput input = bench.input(2, 1);
  auto data = std::make_shared<ImageFeatures>(input.frame->data());
  std::vector<std::uint32_t> changed;
  for (std::uint32_t i = 0; i < data->features.size(); ++i) {
    std::uint8_t& level = data->features.levels[i];
    if (bench.seen[2][i] < 100 || level < least_level || level > most_level) continue;
    change(data->features.keypoints[i], level);
    changed.push_back(i);
  }
  input.frame = std::make_shared<FeatureFrame>(std::move(data), bench.world.camera, 0.0);
  bench.mapping.process(input);
  const std::vector<std::int64_t>& landmarks = bench.map.graph.keyframe(2).landmarks;
  double found = 0.0;
  for (const std::uint32_t feature : changed) found += landmarks[feature] >= 0 ? 1.0 : 0.0;
  EXPECT_GT(changed.size(), 20U);
  return found / static_cast<double>(changed.size());
}

/// Levels of nearly the same distance may be two from each other.
TEST(Triangulation, TheLevelsMustSuitEachOther) {
  for (const int by : {2, 3}) {
    const double coarser = share_triangulated([&](Keypoint&, std::uint8_t& level) { level += by; }, 1, 3);
    const double finer = share_triangulated([&](Keypoint&, std::uint8_t& level) { level -= by; }, 4, 7);
    for (const double share : {coarser, finer}) {
      EXPECT_TRUE(by == 2 ? share > 0.9 : share < 0.15) << by << ' ' << share;
    }
  }
}

/// The motion is to the side, so that lines are nearly horizontal: 1.96 sigma is the limit.
TEST(Triangulation, AFeatureMayBeTwoSigmaFromTheLineOfTheOther) {
  const auto moved_by = [](double sigmas) {
    const auto move = [=](Keypoint& keypoint, std::uint8_t& level) {
      keypoint.y += static_cast<float>(sigmas * std::pow(1.2, level));
    };
    return share_triangulated(move, 0, 7);
  };
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_GT(moved_by(1.7 * sign), 0.8);
    EXPECT_LT(moved_by(2.2 * sign), 0.05);
  }
}

/// With what all keyframes see of it, also of landmarks that were only tracked, fused or measured by depth.
TEST(LocalMapping, EveryLandmarkIsDescribedByAllItsObservations) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    MappingBench bench(sensor, testing::without_keyframe_culling());
    for (const int id : {0, 1}) bench.add_keyframe(id);
    bench.forget_second_half();
    bench.mapping.process(bench.input(2, 1));
    MapGraph& graph = bench.map.graph;
    std::size_t of_three = 0;
    for (const std::int64_t id : graph.landmark_ids()) {
      const MapLandmark before = graph.landmark(id);
      graph.describe(id);
      EXPECT_LT((before.direction - graph.landmark(id).direction).norm(), 1e-3) << id;
      EXPECT_EQ(before.descriptor.words, graph.landmark(id).descriptor.words);
      of_three += before.observations.size() == 3 ? 1U : 0U;
    }
    EXPECT_GT(of_three, 150U);
  }
}

}  // namespace
}  // namespace rastro
