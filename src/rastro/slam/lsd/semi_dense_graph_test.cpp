// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/semi_dense_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/slam/lsd/map_depths.h"

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

TEST(SemiDenseGraph, TheMapKeepsTheMostCertainDepthsOfAKeyframe) {
  LsdOptions options;
  options.max_depth_sigma = 0.0;
  options.map_share = 1.0 / 1200.0;
  const auto most_certain = pixels_in_map(options);
  ASSERT_EQ(most_certain.size(), 1U) << "one of 40 x 30";
  EXPECT_EQ(most_certain[0].x, 5);

  SemiDenseGraph graph(options, false);
  SemiDenseKeyframe keyframe{0, 0, 0, GrayImage(40, 30), InverseDepthMap(40, 30)};
  for (const int x : {3, 9, 21}) {
    keyframe.depth.mean.at(x, 7) = 0.5F;
    keyframe.depth.variance.at(x, 7) = 0.01F;
  }
  graph.add(std::make_shared<const SemiDenseKeyframe>(std::move(keyframe)), Sim3(), 0);
  const auto first = graph.snapshot(single_camera(Camera{}))->layer<SemiDenseLayer>()->of.at(0)->pixels;
  ASSERT_EQ(first.size(), 1U) << "equally certain ones count in their order";
  EXPECT_EQ(first[0].x, 3);
}

TEST(SemiDenseGraph, TheNextMapHasTheDepthsOfTheLastOneWhereNothingChanged) {
  SemiDenseGraph graph = graph_of({}, 3);
  KnownMapDepths known;
  const auto next = [&] { return graph.snapshot(single_camera(Camera{}), &known); };
  const auto depths_in = [](const std::shared_ptr<const Map>& map, std::int64_t id) {
    return map->layer<SemiDenseLayer>()->of.at(id);
  };
  const auto first = next();
  graph.set_poses(
      {Sim3(2.0, SO3(), {1.0, 0.0, 0.0}), Sim3(2.0, SO3(), {0.0, 0.0, 0.0}), Sim3(2.2, SO3(), {0.0, 0.0, 0.0})});
  graph.replace(std::make_shared<const SemiDenseKeyframe>(graph.keyframe(1)));
  const auto second = next();
  EXPECT_EQ(depths_in(second, 0), depths_in(first, 0));
  EXPECT_NE(depths_in(second, 1), depths_in(first, 1)) << "better depths";
  EXPECT_NE(depths_in(second, 2), depths_in(first, 2)) << "another scale";
  EXPECT_FLOAT_EQ(depths_in(second, 2)->pixels[0].inverse_depth, 0.5F / 2.2F);
  EXPECT_NE(depths_in(graph.snapshot(single_camera(Camera{})), 0), depths_in(first, 0)) << "the final map is exact";
}

/// A walk of three keyframes whose scale drifts by 10 % from one to the next.
TEST(SemiDenseGraph, DepthsInTheMapAreAsUncertainAsTheScaleOfTheirKeyframe) {
  LsdOptions options;
  options.surface_share = 0.0;
  options.scale_drift_share = 0.1;
  const auto relative_variances = [&](const std::vector<Constraint>& edges) {
    SemiDenseGraph graph = graph_of(options, 3);
    for (const Constraint& edge : edges) graph.add_edge(edge);
    const auto map = graph.snapshot(single_camera(Camera{}));
    std::vector<double> found;
    for (const auto& [id, depths] : map->layer<SemiDenseLayer>()->of) {
      EXPECT_EQ(depths->pixels.size(), 1U) << "the same ones as with a certain scale";
      found.push_back(static_cast<double>(depths->pixels[0].variance) / (0.25 * 0.25));
    }
    return found;
  };
  constexpr double own = 0.05 * 0.05, drift = 0.1 * 0.1;
  const std::vector<Constraint> walk{{0, 1, Sim3(), Matrix6d::Identity()}, {1, 2, Sim3(), Matrix6d::Identity()}};
  const std::vector<double> open = relative_variances(walk);
  ASSERT_EQ(open.size(), 3U);
  EXPECT_NEAR(open[0], own + drift * 5.0 / 9.0, 1e-6);
  EXPECT_NEAR(open[1], own + drift * 2.0 / 9.0, 1e-6);
  EXPECT_NEAR(open[2], open[0], 1e-6);

  std::vector<Constraint> near = walk, closed = walk;
  near.push_back({0, 2, Sim3(), Matrix6d::Identity(), ConstraintKind::proximity});
  EXPECT_EQ(relative_variances(near), open) << "of the same images";
  closed.push_back({0, 2, Sim3(), Matrix6d::Identity(), ConstraintKind::loop});
  EXPECT_LT(relative_variances(closed)[2], own + 0.5 * (open[2] - own));
  options.scale_drift_share = 0.0;
  EXPECT_NEAR(relative_variances(walk)[2], own, 1e-6);
}

TEST(SemiDenseGraph, WhatTheMapTakesCountsToo) {
  LsdOptions options;
  options.map_share = 1.0 / 1200.0;
  const std::size_t one_each = graph_of(options, 3).bytes();
  options.map_share = 1.0;
  EXPECT_EQ(graph_of(options, 3).bytes(), one_each + 3 * sizeof(SemiDenseDepth::Pixel)) << "two depths each";
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

SemiDenseGraph graph_without_depths(bool metric, std::int64_t keyframes, double length) {
  LsdOptions options;
  options.scale_drift_share = 0.0;
  SemiDenseGraph graph(options, metric);
  for (std::int64_t id = 0; id < keyframes; ++id) {
    const SemiDenseKeyframe keyframe{id, id, id, GrayImage(), InverseDepthMap()};
    graph.add(std::make_shared<const SemiDenseKeyframe>(keyframe),
              Sim3(1.0, SO3(), {static_cast<double>(id) * length, 0.0, 0.0}), 0);
  }
  return graph;
}

Constraint edge_of(std::int64_t from, std::int64_t to, double length, double scale_variance = 0.0,
                   ConstraintKind kind = ConstraintKind::odometry) {
  Constraint edge{from, to, Sim3(1.0, SO3(), {length, 0.0, 0.0}), 1e3 * Matrix6d::Identity(), kind};
  edge.scale_variance = scale_variance;
  return edge;
}

TEST(SemiDenseGraph, TheScaleIsAsUncertainAsWhatTellsItBest) {
  for (const bool metric : {false, true}) {
    SemiDenseGraph graph = graph_without_depths(metric, 4, 1.0);
    graph.add_edge(edge_of(0, 1, 1.0));
    graph.add_edge(edge_of(1, 2, 1.0, 0.16));
    graph.add_edge(edge_of(2, 3, 1.0, 0.09));
    const auto expect = [&](double of_2, double of_3, const char* when) {
      EXPECT_EQ(graph.scale_error(1), 0.0) << when;
      EXPECT_NEAR(graph.scale_error(2), metric ? 0.0 : of_2, 1e-9) << when;
      EXPECT_NEAR(graph.scale_error(3), metric ? 0.0 : of_3, 1e-9) << when;
    };
    expect(0.4, 0.5, "by the motions alone");
    graph.know_scale(3, 0.2);
    expect(0.4, 0.5, "worse than known");
    graph.add_edge(edge_of(0, 3, 3.0, 0.81, ConstraintKind::loop));
    graph.optimize();
    expect(0.4, 0.5, "a loop that knows less");
    graph.add_edge(edge_of(0, 3, 0.1, 0.01, ConstraintKind::loop));
    graph.optimize();
    expect(0.4, 0.5, "a loop that all others contradict");
    graph.add_edge(edge_of(0, 3, 3.0, 0.01, ConstraintKind::loop));
    graph.optimize();
    expect(std::sqrt(0.1), 0.1, "a loop that fits, and back from there");
    graph.know_scale(2, 0.04);
    expect(0.2, 0.1, "better depths");
  }
}

/// 31 poses instead of 199 to move, whatever the length of the walk.
TEST(SemiDenseGraph, WithoutALoopThePosesFarAwayInALargeMapStay) {
  const auto optimized = [](std::int64_t keyframes) {
    SemiDenseGraph graph = graph_without_depths(true, keyframes, 1.1);
    for (std::int64_t id = 1; id < keyframes; ++id) graph.add_edge(edge_of(id - 1, id, 1.0));
    graph.optimize(keyframes - 1);
    return graph;
  };
  const auto x_of = [](const SemiDenseGraph& graph, std::int64_t id) { return graph.pose(id).translation().x(); };
  const SemiDenseGraph large = optimized(200);
  EXPECT_EQ(x_of(large, 168), 168 * 1.1);
  EXPECT_NEAR(x_of(large, 169), 168 * 1.1 + 1.0, 1e-3);
  EXPECT_NEAR(x_of(large, 199), 168 * 1.1 + 31.0, 1e-3);
  EXPECT_NEAR(x_of(optimized(150), 149), 149.0, 1e-3);
}

TEST(SemiDenseGraph, AnotherSubmapsScaleIsAsUncertainAsThatOfTheKeyframeItIsJoinedTo) {
  SemiDenseGraph graph = graph_without_depths(false, 2, 1.0);
  graph.add_edge(edge_of(0, 1, 1.0, 0.09));
  const SemiDenseKeyframe apart{2, 2, 2, GrayImage(), InverseDepthMap()};
  graph.add(std::make_shared<const SemiDenseKeyframe>(apart), Sim3(1.0, SO3(), {2.0, 0.0, 0.0}), 1);
  EXPECT_EQ(graph.scale_error(2), 0.0) << "relative to itself";
  const Constraint joint = edge_of(1, 2, 1.0, 0.16, ConstraintKind::merge);
  graph.merge(joint);
  graph.add_edge(joint);
  graph.optimize();
  EXPECT_NEAR(graph.scale_error(1), 0.3, 1e-9);
  EXPECT_NEAR(graph.scale_error(2), 0.5, 1e-9);
}

TEST(SemiDenseGraph, WhatALoopTellsOfTheScaleIsCorrectedWhereTheScaleIsUncertain) {
  double first_of_all = 0.0;
  for (const double turn_variance : {0.0, 0.04}) {
    SemiDenseGraph graph = graph_without_depths(false, 6, 1.0);
    for (std::int64_t id = 1; id < 6; ++id) graph.add_edge(edge_of(id - 1, id, 1.0, id == 3 ? turn_variance : 0.0));
    Constraint loop = edge_of(0, 5, 5.0, 0.0, ConstraintKind::loop);
    loop.from_from_to = Sim3(1.05, SO3(), {5.0, 0.0, 0.0});
    graph.add_edge(loop);
    graph.optimize();
    const auto change = [&](std::int64_t from) {
      return std::log(graph.pose(from + 1).scale() / graph.pose(from).scale());
    };
    if (turn_variance == 0.0) {
      first_of_all = change(0);
      EXPECT_GT(first_of_all, 0.004) << "a part of 0.05 in each";
      continue;
    }
    for (const std::int64_t other : {0, 1, 3, 4}) EXPECT_LT(std::abs(change(other)), 0.5 * first_of_all) << other;
    EXPECT_GT(change(2), 0.03);
  }
}

}  // namespace
}  // namespace rastro
