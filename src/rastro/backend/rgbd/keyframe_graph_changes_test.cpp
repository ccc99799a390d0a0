// SPDX-License-Identifier: Apache-2.0
// What a graph tells of its changes, and how far it looks.
#include <gtest/gtest.h>

#include <algorithm>

#include "rastro/backend/rgbd/keyframe_graph.h"
#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::bare_keyframe;
using testing::edge_of;
using testing::in_submap;

SE3 ahead(double x) { return SE3(SO3(), {x, 0.0, 0.0}); }

/// Keyframes half a meter apart, which tracking has 1 cm too far apart.
KeyframeGraph row_of(int count, const RgbdSlamOptions& options, int submaps_from = 1000) {
  KeyframeGraph graph(options, 0);
  for (int k = 0; k < count; ++k) {
    graph.add(bare_keyframe(k), in_submap(ahead(0.51 * k), k < submaps_from ? 0 : 1), Matrix6d::Zero());
    if (k > 0 && k != submaps_from) graph.add_edge(edge_of(k - 1, k, ahead(0.5)));
  }
  return graph;
}

/// A copy that is told of every change, as the tracker is.
struct Follower {
  std::vector<KeyframePose> poses;
  std::vector<double> weights;

  void follow(KeyframeGraph& graph) {
    const GraphChanges changes = graph.take_changes();
    poses.resize(static_cast<std::size_t>(changes.first_pose));
    poses.insert(poses.end(), changes.poses.begin(), changes.poses.end());
    weights.resize(graph.edges().size(), -1.0);
    for (const auto& [edge, weight] : changes.weights) weights[edge] = weight;
  }

  void expect_same_as(const KeyframeGraph& graph, const std::string& when) const {
    ASSERT_EQ(poses.size(), static_cast<std::size_t>(graph.size())) << when;
    for (std::int64_t id = 0; id < graph.size(); ++id) {
      const KeyframePose& pose = poses[static_cast<std::size_t>(id)];
      EXPECT_EQ(pose.world_from_camera.matrix(), graph.pose(id).matrix()) << when << " " << id;
      EXPECT_EQ(pose.submap, graph.submap(id)) << when << " " << id;
    }
    for (std::size_t e = 0; e < weights.size(); ++e) EXPECT_EQ(weights[e], graph.edges()[e].weight) << when << " " << e;
  }
};

TEST(GraphChanges, WhoFollowsThemHasTheGraph) {
  RgbdSlamOptions options;
  options.graph_window = 3;
  KeyframeGraph graph = row_of(10, options, 6);
  Follower follower;
  follower.follow(graph);
  follower.expect_same_as(graph, "at first");
  graph.optimize(false);
  follower.follow(graph);
  follower.expect_same_as(graph, "after a window");
  graph.add(bare_keyframe(10), in_submap(ahead(5.2), 1), Matrix6d::Zero());
  graph.add_edge(edge_of(9, 10, ahead(0.5)));
  graph.add_edge(edge_of(2, 10, ahead(40.0), ConstraintKind::merge));
  graph.merge(graph.edges().back());
  follower.follow(graph);
  follower.expect_same_as(graph, "after a merge");
  EXPECT_EQ(graph.submap_count(), 1);
  graph.add_edge(edge_of(1, 4, ahead(-30.0), ConstraintKind::loop));
  graph.optimize(true);
  follower.follow(graph);
  follower.expect_same_as(graph, "after all");
  EXPECT_LT(follower.weights.back(), 0.1) << "it contradicts the others";
}

TEST(GraphChanges, AreTheWindowAloneAndToldOnce) {
  RgbdSlamOptions options;
  options.graph_window = 3;
  KeyframeGraph graph = row_of(10, options);
  EXPECT_EQ(graph.take_changes().poses.size(), 10U);
  EXPECT_TRUE(graph.take_changes().poses.empty());
  EXPECT_TRUE(graph.take_changes().weights.empty());
  graph.optimize(false);
  const GraphChanges changes = graph.take_changes();
  EXPECT_EQ(changes.first_pose, 7);
  EXPECT_EQ(changes.poses.size(), 3U);
  EXPECT_EQ(changes.weights.size(), 3U) << "the edges at these";
}

/// The first keyframe of what two submaps become is that of the older one.
TEST(GraphChanges, AMergedSubmapIsAnchoredByItsFirstKeyframe) {
  KeyframeGraph graph = row_of(8, {}, 4);
  graph.add_edge(edge_of(1, 6, ahead(2.5), ConstraintKind::merge));
  graph.merge(graph.edges().back());
  const SE3 first = graph.pose(0), fourth = graph.pose(4);
  graph.optimize(true);
  EXPECT_EQ(graph.pose(0).matrix(), first.matrix());
  EXPECT_NE(graph.pose(4).matrix(), fourth.matrix()) << "no longer the first of its own";
}

TEST(GraphPaths, FollowNoMoreThanTheyAreAskedFor) {
  int asked = 0;
  GraphPaths paths(0, [&](std::int64_t id) {
    ++asked;
    return std::vector<GraphPaths::Link>{{id + 1, 1.0}, {id - 1, 1.0}};  // without an end
  });
  EXPECT_EQ(paths.to(0), 0.0);
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(paths.to(-5), 5.0);
  EXPECT_LE(asked, 11);
  const int before = asked;
  EXPECT_EQ(paths.to(3), 3.0);
  EXPECT_EQ(asked, before) << "known by then";
}

TEST(FinalOptimization, IsCompleteForSmallMapsAndBoundedForLargeOnes) {
  for (const std::size_t edges : {std::size_t{0}, std::size_t{100}, std::size_t{16000}}) {
    EXPECT_TRUE(final_optimization(edges, 10).gradual) << edges;
    EXPECT_EQ(final_optimization(edges, 10).rounds, 10) << edges;
  }
  double most = 0.0;
  for (std::size_t edges = 20000; edges < 300000; edges += 1000) {
    const FinalOptimization limits = final_optimization(edges, 10);
    EXPECT_GE(limits.rounds, 1);
    most = std::max(most, 10.0 * static_cast<double>(edges) * (limits.rounds + (limits.gradual ? 8 : 0)));
  }
  EXPECT_LE(most, 3.1e6);
  EXPECT_FALSE(final_optimization(100000, 10).gradual) << "what loop closures decided stands";
  EXPECT_EQ(final_optimization(10000000, 10).rounds, 1) << "one at least";
}

}  // namespace
}  // namespace rastro
