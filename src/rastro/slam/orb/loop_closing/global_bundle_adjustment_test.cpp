// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/loop_closing/global_bundle_adjustment.h"

#include <gtest/gtest.h>

#include "rastro/slam/orb/loop_closing/place_testing.h"
#include "rastro/slam/orb/options.h"

namespace rastro {
namespace {

using testing::DriftingMapper;
using testing::RoundWorld;

/// A map of keyframes 36 degrees apart, exact except for pixel noise.
struct TrueMap {
  explicit TrueMap(int keyframes) {
    mapper.begin(0, RoundWorld::world_from_camera(0.0), 1.0);
    for (int k = 0; k < keyframes; ++k) mapper.add(0.1 * k);
  }

  /// Perturbs all keyframes but the first, and the landmarks.
  void shake() {
    for (const std::int64_t id : graph.keyframe_ids()) {
      if (id > 0) graph.keyframe(id).camera_from_world = draw() * graph.keyframe(id).camera_from_world;
    }
    for (const std::int64_t id : graph.landmark_ids()) graph.landmark(id).position += draw().translation();
  }

  /// Largest position error of keyframes 0..count-1.
  double error(std::int64_t count) const {
    double largest = 0.0;
    for (std::int64_t id = 0; id < count; ++id) {
      const Eigen::Vector3d center = graph.camera_from_world(id).inverse().translation();
      largest = std::max(largest, (center - mapper.centers[static_cast<std::size_t>(id)]).norm());
    }
    return largest;
  }

  SE3 draw() {
    Eigen::Matrix<double, 6, 1> small;
    for (int i = 0; i < 6; ++i) small(i) = 0.05 * random.normal();
    return SE3::exp(small);
  }

  Random random{5};
  RoundWorld world{2};
  MapGraph graph{world.camera, CameraKind::depth, 0.1, OrbOptions{}};
  DriftingMapper mapper{world, graph, 0.0, 1.0};
};

TEST(GlobalBundleAdjustment, MovesKeyframesToGroundTruth) {
  TrueMap map(12);
  map.shake();
  EXPECT_GT(map.error(12), 0.1);
  GlobalBundleAdjustment adjustment(map.graph, 0, 1.0);
  adjustment.run(10, nullptr, nullptr);
  EXPECT_GT(map.error(12), 0.1) << "the map stays as it is until it is taken over";
  adjustment.apply(map.graph);
  EXPECT_LT(map.error(12), 0.04);
}

TEST(GlobalBundleAdjustment, IsAppliedToTheCurrentMap) {
  TrueMap map(12);
  map.shake();
  GlobalBundleAdjustment adjustment(map.graph, 0, 1.0);
  adjustment.run(10, nullptr, nullptr);
  const SE3 parent_from_world = map.graph.keyframe(11).camera_from_world;
  const std::int64_t made = map.mapper.add(1.2);
  const SE3 made_from_parent = RoundWorld::world_from_camera(1.2).inverse() * RoundWorld::world_from_camera(1.1);
  map.graph.keyframe(made).camera_from_world = made_from_parent * parent_from_world;
  std::int64_t own = -1;
  for (const std::int64_t id : map.graph.landmark_ids()) {
    if (map.graph.landmark(id).first_keyframe == made) own = id;
  }
  ASSERT_GE(own, 0);
  const Eigen::Vector3d in_made = map.graph.keyframe(made).camera_from_world * map.graph.landmark(own).position;
  map.graph.remove_keyframe(5);
  adjustment.apply(map.graph);
  EXPECT_LT(map.error(5), 0.04);
  EXPECT_LT((map.graph.camera_from_world(11).inverse().translation() - map.mapper.centers[11]).norm(), 0.04);
  const SE3 after = map.graph.keyframe(made).camera_from_world * map.graph.keyframe(11).camera_from_world.inverse();
  EXPECT_LT((after * made_from_parent.inverse()).log().norm(), 1e-9) << "what was made since keeps its relative pose";
  EXPECT_LT((map.graph.keyframe(made).camera_from_world * map.graph.landmark(own).position - in_made).norm(), 1e-9);
}

TEST(GlobalBundleAdjustment, IsWithoutEffectOnceCanceled) {
  TrueMap map(6);
  map.shake();
  GlobalBundleAdjustment adjustment(map.graph, 0, 1.0);
  adjustment.cancel();
  adjustment.run(10, nullptr, nullptr);
  const SE3 before = map.graph.keyframe(3).camera_from_world;
  adjustment.apply(map.graph);
  EXPECT_LT((map.graph.keyframe(3).camera_from_world * before.inverse()).log().norm(), 1e-12);
}

TEST(GlobalBundleAdjustment, IsTheSameForAnyPool) {
  const auto adjusted = [](TaskPool* pool) {
    TrueMap map(8);
    map.shake();
    GlobalBundleAdjustment adjustment(map.graph, 0, 1.0);
    adjustment.run(4, nullptr, pool);
    adjustment.apply(map.graph);
    const Eigen::Matrix4d matrix = map.graph.keyframe(7).camera_from_world.matrix();
    return std::vector<double>(matrix.data(), matrix.data() + 16);
  };
  TaskPool four(4);
  EXPECT_EQ(adjusted(nullptr), adjusted(&four));
}

}  // namespace
}  // namespace rastro
