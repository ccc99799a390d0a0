// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/refinement/final_refinement.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "rastro/slam/lsd/refinement/plane_views_testing.h"

namespace rastro {
namespace {

using testing::depth_at, testing::plane_camera, testing::PlaneViews;

/// The views as keyframes of a map, each with the true depths of all pixels, and its pose as disturbed.
SemiDenseGraph graph_of(const LsdOptions& options, const PlaneViews& views, const GrayImage& mask) {
  const Camera camera = plane_camera();
  SemiDenseGraph graph(options, false);
  for (std::size_t k = 0; k < views.keyframes.size(); ++k) {
    const auto id = static_cast<std::int64_t>(k);
    SemiDenseKeyframe keyframe{id, id, id, views.images[k], InverseDepthMap(camera.width, camera.height)};
    keyframe.mask = mask;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0);
        keyframe.depth.mean.at(x, y) = static_cast<float>(1.0 / depth_at(views.world_from_camera[k], ray));
        keyframe.depth.variance.at(x, y) = 1e-4F;
      }
    const SE3 pose = views.keyframes[k].camera_from_world.inverse();
    graph.add(std::make_shared<const SemiDenseKeyframe>(std::move(keyframe)),
              Sim3(1.0, pose.rotation(), pose.translation()), 0);
  }
  for (std::int64_t from = 0; from < graph.size(); ++from)
    for (std::int64_t to = from + 1; to < graph.size(); ++to)
      graph.add_edge({from, to, Sim3(), Matrix6d::Identity(), ConstraintKind::proximity});
  return graph;
}

TEST(FinalRefinement, MaskedPixelsAreNotCompared) {
  const LsdOptions options;
  PlaneViews views;
  views.disturb(7);
  const LsdSensor sensor = single_camera(plane_camera());
  const GrayImage nothing(plane_camera().width, plane_camera().height);
  const SemiDenseGraph all = graph_of(options, views, {}), masked = graph_of(options, views, nothing);
  FinalRefinement with_all(options, all, sensor), with_none(options, masked, sensor);
  with_all.run(nullptr, [] { return false; }, {});
  with_none.run(nullptr, [] { return false; }, {});
  EXPECT_TRUE(with_all.is_better());
  EXPECT_FALSE(with_none.is_better());
}

/// Else what is left of the map would move as a whole, away from the keyframes without depths.
TEST(FinalRefinement, TheFirstKeyframeThatIsLeftStaysWhenTheFirstOfAllWasForgotten) {
  const LsdOptions options;
  PlaneViews views;
  views.disturb(7);
  SemiDenseGraph graph = graph_of(options, views, {});
  ASSERT_TRUE(graph.forget_oldest(4));
  FinalRefinement refinement(options, graph, single_camera(plane_camera()));
  refinement.run(nullptr, [] { return false; }, {});
  ASSERT_TRUE(refinement.is_better());
  const std::vector<Sim3> poses = refinement.poses();
  for (const std::size_t kept : {0U, 1U})
    EXPECT_LT((poses[kept].translation() - graph.pose(static_cast<std::int64_t>(kept)).translation()).norm(), 1e-9)
        << kept;
  EXPECT_GT((poses[2].translation() - graph.pose(2).translation()).norm(), 1e-5);
}

/// Uncertain depths that all err to the same side are more than half of all.
TEST(FinalRefinement, TheScaleOfAKeyframeIsThatOfItsCertainDepths) {
  const LsdOptions options;
  const PlaneViews views;
  SemiDenseGraph graph = graph_of(options, views, {});
  for (std::int64_t id = 0; id < graph.size(); ++id) {
    SemiDenseKeyframe keyframe = graph.keyframe(id);
    for (int y = 0; y < keyframe.depth.height(); ++y)
      for (int x = 0; x < keyframe.depth.width(); ++x) {
        const bool is_certain = (x / 8 + y / 8) % 5 < 2;
        float& mean = keyframe.depth.mean.at(x, y);
        const float sigma = (is_certain ? 0.01F : 0.06F) * mean;
        if (!is_certain) mean *= 1.06F;
        keyframe.depth.variance.at(x, y) = sigma * sigma;
      }
    graph.replace(std::make_shared<const SemiDenseKeyframe>(std::move(keyframe)));
  }
  FinalRefinement refinement(options, graph, single_camera(plane_camera()));
  refinement.run(nullptr, [] { return false; }, {});
  const std::vector<Sim3> poses = refinement.poses();
  const double map_scale = poses.back().translation().norm() / views.world_from_camera.back().translation().norm();
  for (const Sim3& pose : poses) EXPECT_NEAR(pose.scale() / map_scale, 1.0, 0.02);
}

}  // namespace
}  // namespace rastro
