// SPDX-License-Identifier: Apache-2.0
// Loops that change the unit of a map, and how soon after one another they may come.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "rastro/slam/orb/loop_closing/loop_closing.h"
#include "rastro/slam/orb/loop_closing/loop_correction.h"
#include "rastro/slam/orb/loop_closing/place_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::DriftingMapper;
using testing::ExactMap;
using testing::PointWorld;
using testing::RoundWorld;

/// Keyframes 0 to 5 of one camera in a row, each of which shares landmarks with the next.
struct MonoRow {
  MonoRow() : map(world, CameraKind::mono, 0.0) {
    for (int k = 0; k < 6; ++k) {
      const auto first = static_cast<std::uint32_t>(40 * k);
      map.add(k, SE3(SO3::exp({0.01 * k, -0.02 * k, 0.03 * k}), {-0.2 * k, 0.05 * k, 0.02 * k}),
              {.from = first, .to = first + 80});
    }
  }
  PointWorld world{300, 5};
  ExactMap map;
  MapGraph& graph = map.graph;
};

/// A loop from the last to the first that measures `scale`, and 0.1 m beside.
VerifiedLoop scaling_loop(const MapGraph& graph, double scale) {
  VerifiedLoop loop;
  loop.keyframe = 5;
  loop.matched = 0;
  const SE3 relative = graph.camera_from_world(5) * graph.camera_from_world(0).inverse();
  loop.keyframe_from_matched =
      Sim3(scale, relative.rotation(), scale * relative.translation() + Eigen::Vector3d(0.0, 0.1, 0.0));
  return loop;
}

TEST(LoopCorrection, EveryLandmarkKeepsItsPlaceInItsKeyframesViewAndUnit) {
  for (const double scale : {0.8, 1.3}) {
    MonoRow row;
    MapGraph& graph = row.graph;
    std::map<std::int64_t, std::pair<std::int64_t, Eigen::Vector3d>> before;  // by landmark: keyframe, and seen from it
    for (const std::int64_t id : graph.landmark_ids()) {
      const MapLandmark& landmark = graph.landmark(id);
      // It moves with the keyframe of the loop, or the next one to it, or the one that made it.
      const std::int64_t with = graph.feature_of(5, id) >= 0   ? 5
                                : graph.feature_of(4, id) >= 0 ? 4
                                                               : landmark.first_keyframe;
      before[id] = {with, graph.camera_from_world(with) * landmark.position};
    }
    const LoopResult result = correct_loop(graph, OrbSlamOptions(), scaling_loop(graph, scale));
    EXPECT_NEAR(result.scale, 1.0 / scale, 1e-12);
    EXPECT_EQ(result.fused, 0);
    ASSERT_EQ(graph.landmark_ids().size(), before.size());
    for (const auto& [id, seen] : before) {
      const Eigen::Vector3d after = graph.camera_from_world(seen.first) * graph.landmark(id).position;
      EXPECT_LT((after - graph.unit(seen.first) * seen.second).norm(), 1e-9) << id;
    }
  }
}

TEST(LoopCorrection, TheUnitChangesFromThatOfTheHeldEndToThatOfTheLoop) {
  for (const double scale : {0.8, 1.3}) {
    MonoRow row;
    correct_loop(row.graph, OrbSlamOptions(), scaling_loop(row.graph, scale));
    EXPECT_NEAR(row.graph.unit(0), 1.0, 1e-12);
    double previous = 0.0;
    for (std::int64_t id = 1; id < 6; ++id) {
      const double share = std::log(row.graph.unit(id)) / std::log(1.0 / scale);
      EXPECT_GT(share, previous) << id;
      EXPECT_LT(share, 1.0) << id;
      previous = share;
    }
    EXPECT_GT(previous, 0.6);
  }
}

TEST(LoopCorrection, ALoopOfADepthCameraLeavesTheUnit) {
  const PointWorld world(300, 5);
  ExactMap map(world, CameraKind::depth, 0.1);
  for (int k = 0; k < 6; ++k)
    map.add(k, SE3(SO3(), {-0.2 * k, 0.0, 0.0}),
            {.from = static_cast<std::uint32_t>(40 * k), .to = static_cast<std::uint32_t>(40 * k + 80)});
  correct_loop(map.graph, OrbSlamOptions(), scaling_loop(map.graph, 1.0));
  for (std::int64_t id = 0; id < 6; ++id) EXPECT_NEAR(map.graph.unit(id), 1.0, 1e-12) << id;
}

/// A place is mapped, and then visited again and again by submaps of one keyframe.
TEST(LoopClosing, TheNextLoopIsSearchedForAsSoonAsTheGapAllows) {
  for (const int gap : {0, 1, 2, 4}) {
    OrbSlamOptions options;
    options.loop_consistent = 1;
    options.loop_min_gap = gap;
    RoundWorld world(1);
    MapGraph graph(world.camera, CameraKind::depth, 0.1, OrbOptions{});
    KeyframeDatabase database(graph, world.vocabulary());
    LoopClosing loop_closing(options, graph, database);
    DriftingMapper mapper(world, graph, 0.0, 1.0);
    constexpr double turn = 2.0 * M_PI / 60.0;
    mapper.begin(0, SE3(), 1.0);
    for (int k = 0; k < 14; ++k) EXPECT_FALSE(loop_closing.process(mapper.add(k * turn))) << k;
    mapper.begin(1, SE3(SO3::exp({0.3, 1.0, -0.4}), {3.0, -2.0, 1.0}), 1.0);
    const std::int64_t merged = mapper.add(7.3 * turn);
    ASSERT_TRUE(loop_closing.process(merged)) << "nothing was closed before";
    for (int k = 1; k <= 4; ++k) {
      mapper.begin(1 + k, SE3(SO3::exp({-0.3, 0.5, 0.4}), {1.0, 2.0, 5.0}), 1.0);
      const std::int64_t id = mapper.add((5.0 + 0.3 * k) * turn);
      const bool closed = loop_closing.process(id).has_value();
      EXPECT_EQ(closed, id == merged + std::max(gap, 1)) << gap << ' ' << k;
      if (closed) break;
    }
  }
}

/// A closed loop confirms no other one.
TEST(LoopClosing, AfterALoopTheNextOneMustBeConfirmedAnew) {
  OrbSlamOptions options;
  options.loop_consistent = 2;
  options.loop_min_gap = 1;
  RoundWorld world(1);
  MapGraph graph(world.camera, CameraKind::depth, 0.1, OrbOptions{});
  KeyframeDatabase database(graph, world.vocabulary());
  LoopClosing loop_closing(options, graph, database);
  DriftingMapper mapper(world, graph, 0.0, 1.0);
  constexpr double turn = 2.0 * M_PI / 60.0;
  mapper.begin(0, SE3(), 1.0);
  for (int k = 0; k < 14; ++k) EXPECT_FALSE(loop_closing.process(mapper.add(k * turn))) << k;
  // Each keyframe from now on is alone in its submap, so that it is connected to nothing.
  for (int k = 0; k < 4; ++k) {
    mapper.begin(1 + k, SE3(SO3::exp({0.3, 1.0, -0.4}), {3.0, -2.0, 1.0}), 1.0);
    EXPECT_EQ(loop_closing.process(mapper.add((6.3 + 0.3 * k) * turn)).has_value(), k % 2 == 1) << k;
  }
}

}  // namespace
}  // namespace rastro
