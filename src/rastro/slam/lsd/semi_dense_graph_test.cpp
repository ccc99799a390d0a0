// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/semi_dense_graph.h"

#include <gtest/gtest.h>

#include "rastro/map/semi_dense/semi_dense_layer.h"

namespace rastro {
namespace {

/// Keyframes with two depths each: certain to 5 and to 20 %.
SemiDenseGraph graph_of(const LsdOptions& options, std::int64_t keyframes) {
  SemiDenseGraph graph(options, false);
  for (std::int64_t id = 0; id < keyframes; ++id) {
    SemiDenseKeyframe keyframe{id, id, id, GrayImage(40, 30), InverseDepthMap(40, 30)};
    keyframe.depth.mean.at(5, 5) = keyframe.depth.mean.at(25, 20) = 0.5F;
    keyframe.depth.variance.at(5, 5) = 0.025F * 0.025F;
    keyframe.depth.variance.at(25, 20) = 0.1F * 0.1F;
    graph.add(std::make_shared<const SemiDenseKeyframe>(std::move(keyframe)), Sim3(2.0, SO3(), {0.0, 0.0, 0.0}), 0);
  }
  return graph;
}

std::vector<SemiDenseDepth::Pixel> pixels_in_map(const LsdOptions& options) {
  const auto map = graph_of(options, 1).snapshot(single_camera(Camera{}));
  return map->layer<SemiDenseLayer>()->of.at(0)->pixels;
}

TEST(SemiDenseGraph, DepthsThatSayLittleAreLeftOutOfTheMap) {
  LsdOptions options;
  const auto certain = pixels_in_map(options);
  ASSERT_EQ(certain.size(), 1U);
  EXPECT_EQ(certain[0].x, 5);
  EXPECT_FLOAT_EQ(certain[0].inverse_depth, 0.25F) << "in the world's unit";
  options.max_depth_sigma = 0.0;
  EXPECT_EQ(pixels_in_map(options).size(), 2U);
}

TEST(SemiDenseGraph, ALoopIsClosedByConstraintsWithEarlierVisitsAlone) {
  SemiDenseGraph graph = graph_of({}, 3);
  graph.add_edge({1, 2, Sim3(), Matrix6d::Identity()});
  graph.add_edge({0, 2, Sim3(), Matrix6d::Identity(), ConstraintKind::proximity});
  EXPECT_FALSE(graph.closes_loop(2));
  graph.add_edge({0, 2, Sim3(), Matrix6d::Identity(), ConstraintKind::loop});
  EXPECT_TRUE(graph.closes_loop(2));
  EXPECT_FALSE(graph.closes_loop(0));
}

TEST(SemiDenseGraph, StepsFollowWhatWasMadeOfWhat) {
  SemiDenseGraph graph = graph_of({}, 6);
  for (const auto& [from, to] : {std::pair{0, 1}, {1, 2}, {2, 3}, {1, 4}, {4, 5}})
    graph.add_edge({from, to, Sim3(), Matrix6d::Identity()});
  graph.add_edge({0, 5, Sim3(), Matrix6d::Identity(), ConstraintKind::loop});
  EXPECT_EQ(graph.within_steps(5, 2), (std::vector<std::int64_t>{1, 4}));
  EXPECT_EQ(graph.within_steps(1, 1), (std::vector<std::int64_t>{0, 2, 4}));
  EXPECT_EQ(graph.within_steps(1, 10), (std::vector<std::int64_t>{0, 2, 3, 4, 5}));
}

}  // namespace
}  // namespace rastro
