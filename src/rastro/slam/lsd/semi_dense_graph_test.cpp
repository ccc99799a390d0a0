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

SemiDenseGraph graph_without_depths(bool metric, std::int64_t keyframes, double way) {
  SemiDenseGraph graph({}, metric);
  for (std::int64_t id = 0; id < keyframes; ++id) {
    const SemiDenseKeyframe keyframe{id, id, id, GrayImage(), InverseDepthMap()};
    graph.add(std::make_shared<const SemiDenseKeyframe>(keyframe),
              Sim3(1.0, SO3(), {static_cast<double>(id) * way, 0.0, 0.0}), 0);
  }
  return graph;
}

Constraint step(std::int64_t from, std::int64_t to, double way, double scale_variance = 0.0) {
  Constraint edge{from, to, Sim3(1.0, SO3(), {way, 0.0, 0.0}), 1e3 * Matrix6d::Identity()};
  edge.scale_variance = scale_variance;
  return edge;
}

TEST(SemiDenseGraph, TheScaleIsAsUncertainAsTheMotionsInATurnUntilALoopTellsIt) {
  for (const bool metric : {false, true}) {
    SemiDenseGraph graph = graph_without_depths(metric, 4, 1.0);
    graph.add_edge(step(0, 1, 1.0));
    graph.add_edge(step(1, 2, 1.0, 0.09));
    graph.add_edge(step(2, 3, 1.0, 0.16));
    EXPECT_EQ(graph.scale_error(1), 0.0);
    EXPECT_NEAR(graph.scale_error(2), metric ? 0.0 : 0.3, 1e-12);
    EXPECT_NEAR(graph.scale_error(3), metric ? 0.0 : 0.5, 1e-12);
    Constraint loop = step(0, 3, 3.0, 1.0);
    loop.kind = ConstraintKind::loop;
    graph.add_edge(loop);
    EXPECT_NEAR(graph.scale_error(3), metric ? 0.0 : 0.5, 1e-12) << "it knows less";
    loop.scale_variance = 0.01;
    graph.add_edge(loop);
    EXPECT_NEAR(graph.scale_error(3), metric ? 0.0 : 0.1, 1e-12);
  }
}

TEST(SemiDenseGraph, WhatALoopCorrectsIsCorrectedWhereTheScaleIsUncertain) {
  double first = 0.0;
  for (const double turn_variance : {0.0, 0.04}) {
    SemiDenseGraph graph = graph_without_depths(false, 5, 0.95);
    for (std::int64_t id = 1; id < 5; ++id)
      graph.add_edge(step(id - 1, id, id == 4 ? 0.8 : 1.0, id == 4 ? turn_variance : 0.0));
    Constraint loop = step(0, 4, 4.0);
    loop.kind = ConstraintKind::loop;
    graph.add_edge(loop);
    graph.optimize();
    const double moved = graph.pose(1).translation().x() - 1.0;
    if (turn_variance == 0.0) {
      first = moved;
      EXPECT_GT(moved, 0.03) << "a part of 0.2 in each step";
    } else {
      EXPECT_LT(moved, 0.25 * first);
      EXPECT_NEAR(graph.pose(4).translation().x(), 4.0, 0.01);
    }
  }
}

}  // namespace
}  // namespace rastro
