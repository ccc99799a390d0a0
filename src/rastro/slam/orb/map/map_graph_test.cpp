// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/map_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "rastro/base/random.h"
#include "rastro/slam/orb/map/graph_testing.h"

namespace rastro {
namespace {

using testing::blank_frame;
using testing::feature_count;
using testing::small_camera;

/// A chain of keyframes whose features observe random landmarks.
MapGraph random_graph(int keyframes, std::uint64_t seed) {
  MapGraph graph(small_camera(), CameraKind::mono, 0.0, {});
  Random random(seed);
  for (int k = 0; k < keyframes; ++k)
    graph.add_keyframe(blank_frame(k), SE3(SO3(), Eigen::Vector3d(-0.1 * k, 0.0, 0.0)), 0, k - 1);
  for (int l = 0; l < 60; ++l) {
    const std::int64_t id = graph.add_landmark({random.uniform(-1, 1), random.uniform(-1, 1), 5.0}, 0).id;
    for (int k = 0; k < keyframes; ++k) {
      if (random.uniform() < 0.5) graph.add_observation(k, random.below(feature_count), id);
    }
  }
  return graph;
}

/// Recounts from the observations; keyframes and landmarks must have the same ones.
void expect_consistent(const MapGraph& graph) {
  std::map<std::pair<std::int64_t, std::int64_t>, int> shared;
  for (const std::int64_t id : graph.landmark_ids()) {
    const auto& seen = graph.landmark(id).observations;
    for (const LandmarkObservation& a : seen) {
      EXPECT_EQ(graph.keyframe(a.keyframe).landmarks[a.feature], id);
      for (const LandmarkObservation& b : seen) {
        if (a.keyframe != b.keyframe) ++shared[{a.keyframe, b.keyframe}];
      }
    }
  }
  for (const std::int64_t a : graph.keyframe_ids()) {
    for (const std::int64_t landmark : graph.keyframe(a).landmarks) {
      if (landmark >= 0) {
        EXPECT_GE(graph.feature_of(a, landmark), 0);
      }
    }
    for (const std::int64_t b : graph.keyframe_ids()) {
      if (a != b) {
        EXPECT_EQ(graph.shared(a, b), (shared[{a, b}])) << a << " " << b;
      }
    }
    const std::int64_t parent = graph.keyframe(a).parent;
    if (parent >= 0) {
      const auto& children = graph.keyframe(parent).children;
      EXPECT_EQ(std::count(children.begin(), children.end(), a), 1);
    }
  }
}

/// One root per submap, all others below it; every child is listed by its parent once and in order.
void expect_spanning_trees(const MapGraph& graph) {
  std::map<int, int> roots;
  std::size_t listed = 0;
  for (const std::int64_t id : graph.keyframe_ids()) {
    const MapKeyframe& keyframe = graph.keyframe(id);
    roots[keyframe.submap] += keyframe.parent < 0 ? 1 : 0;
    EXPECT_TRUE(std::is_sorted(keyframe.children.begin(), keyframe.children.end()));
    for (const std::int64_t child : keyframe.children) EXPECT_EQ(graph.keyframe(child).parent, id);
    listed += keyframe.children.size();
    std::int64_t above = id;
    for (std::size_t steps = 0; above >= 0 && steps <= graph.keyframe_count(); ++steps) {
      EXPECT_EQ(graph.keyframe(above).submap, keyframe.submap);
      above = graph.keyframe(above).parent;
    }
    EXPECT_LT(above, 0) << id << " hangs in a circle";
  }
  for (const auto& [submap, count] : roots) EXPECT_EQ(count, 1) << "submap " << submap;
  EXPECT_EQ(listed, graph.keyframe_count() - roots.size());
}

/// Kruskal's algorithm: shared landmarks along the maximum spanning tree of these keyframes.
int most_shared_by_a_tree(const MapGraph& graph, const std::vector<std::int64_t>& ids) {
  std::vector<std::array<std::int64_t, 3>> edges;
  for (const std::int64_t a : ids) {
    for (const std::int64_t b : ids) {
      if (a < b) edges.push_back({graph.shared(a, b), a, b});
    }
  }
  std::sort(edges.rbegin(), edges.rend());
  std::map<std::int64_t, std::int64_t> part;
  for (const std::int64_t id : ids) part[id] = id;
  int sum = 0;
  for (const auto& [shared, a, b] : edges) {
    const std::int64_t from = part[a], to = part[b];
    if (from == to) continue;
    sum += static_cast<int>(shared);
    for (auto& [id, of] : part) of = of == from ? to : of;
  }
  return sum;
}

TEST(MapGraph, ChildrenOfARemovedKeyframeGetTheParentThatSharesMost) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    MapGraph graph = random_graph(9, seed);
    const std::vector<std::int64_t> orphans = {3, 4, 5, 7};
    for (const std::int64_t child : orphans) graph.set_parent(child, 2);
    expect_spanning_trees(graph);
    graph.remove_keyframe(2);
    expect_spanning_trees(graph);
    int sum = 0;
    for (const std::int64_t child : orphans) {
      const std::int64_t parent = graph.keyframe(child).parent;
      EXPECT_TRUE(parent == 1 || std::count(orphans.begin(), orphans.end(), parent) == 1) << child << " " << parent;
      sum += graph.shared(child, parent);
    }
    EXPECT_EQ(sum, most_shared_by_a_tree(graph, {1, 3, 4, 5, 7})) << "seed " << seed;
    EXPECT_EQ(graph.keyframe(6).parent, 5) << "a grandchild stays where it was";
  }
}

TEST(MapGraph, AnotherRootReversesThePathToItAndNothingElse) {
  const auto pairs_of = [](const MapGraph& graph) {
    std::set<std::pair<std::int64_t, std::int64_t>> pairs;
    for (const std::int64_t id : graph.keyframe_ids()) {
      const std::int64_t parent = graph.keyframe(id).parent;
      if (parent >= 0) pairs.insert(std::minmax(id, parent));
    }
    return pairs;
  };
  MapGraph graph = random_graph(8, 3);
  graph.set_parent(5, 2);
  graph.set_parent(7, 0);
  const auto before = pairs_of(graph);
  for (const std::int64_t root : {6, 7, 3, 0}) {
    graph.make_root(root);
    expect_spanning_trees(graph);
    EXPECT_EQ(graph.keyframe(root).parent, -1);
    EXPECT_EQ(pairs_of(graph), before);
  }
}

TEST(MapGraph, CountsOfSharedLandmarksFollowEveryChange) {
  MapGraph graph = random_graph(8, 3);
  expect_consistent(graph);
  expect_spanning_trees(graph);
  graph.fuse(5, 6);
  EXPECT_EQ(graph.current(6), 5);
  expect_consistent(graph);
  graph.remove_landmark(7);
  EXPECT_EQ(graph.current(7), -1);
  graph.remove_keyframe(3);
  EXPECT_FALSE(graph.has_keyframe(3));
  expect_consistent(graph);
  graph.make_root(6);
  expect_consistent(graph);
  expect_spanning_trees(graph);
  EXPECT_EQ(graph.keyframe(6).parent, -1);
}

TEST(MapGraph, ARemovedKeyframeMovesWithItsParent) {
  MapGraph graph = random_graph(4, 5);
  const SE3 parent = graph.camera_from_world(1), before = graph.camera_from_world(2);
  graph.remove_keyframe(2);
  EXPECT_LT((graph.camera_from_world(2) * before.inverse()).log().norm(), 1e-12);
  const Sim3 moved(2.0, SO3::exp({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0});
  graph.transform(0, moved);
  EXPECT_DOUBLE_EQ(graph.unit(2), 2.0);
  // The center moves with the map.
  const Eigen::Vector3d expected = moved * before.inverse().translation();
  EXPECT_LT((graph.camera_from_world(2).inverse().translation() - expected).norm(), 1e-12);
  const Eigen::Vector3d of_parent = moved * parent.inverse().translation();
  EXPECT_LT((graph.camera_from_world(1).inverse().translation() - of_parent).norm(), 1e-12);
}

TEST(MapGraph, ScalingTheMapChangesNoProjection) {
  MapGraph graph = random_graph(3, 7);
  std::vector<Eigen::Vector3d> before;
  for (const std::int64_t id : graph.landmark_ids())
    before.push_back(graph.camera_from_world(1) * graph.landmark(id).position);
  graph.transform(0, Sim3(0.25, SO3::exp({0.3, -0.2, 0.1}), {4.0, 5.0, 6.0}));
  std::size_t i = 0;
  for (const std::int64_t id : graph.landmark_ids()) {
    if (graph.landmark(id).observations.empty()) {
      ++i;
      continue;
    }
    const Eigen::Vector3d now = graph.camera_from_world(1) * graph.landmark(id).position;
    EXPECT_LT((now - 0.25 * before[i++]).norm(), 1e-9);
  }
}

TEST(MapGraph, ARemovedRootTakesAllItsLandmarksWithIt) {
  MapGraph graph(small_camera(), CameraKind::depth, 0.1, {});
  graph.add_keyframe(blank_frame(0), SE3(), 0, -1);
  graph.add_keyframe(blank_frame(1), SE3(), 1, -1);
  for (std::uint32_t feature = 0; feature < 3; ++feature)
    graph.add_observation(0, feature, graph.add_landmark({0.0, 0.0, 5.0}, 0).id);
  const std::int64_t other = graph.add_landmark({0.0, 0.0, 5.0}, 1).id;
  graph.add_observation(1, 0, other);
  graph.remove_root(0);
  EXPECT_EQ(graph.landmark_ids(), std::vector<std::int64_t>{other});
  EXPECT_EQ(graph.keyframe_ids(), std::vector<std::int64_t>{1});
  EXPECT_EQ(graph.keyframe_count(), 1U);
}

TEST(MapGraph, ATransformationIsOfOneSubmapWithAllThatItsLandmarksKnow) {
  MapGraph graph(small_camera(), CameraKind::mono, 0.0, {});
  const SE3 pose(SO3::exp({0.1, -0.2, 0.3}), {0.5, 0.2, -0.1});
  for (const int submap : {0, 1}) {
    graph.add_keyframe(blank_frame(submap), pose, submap, -1);
    graph.add_observation(submap, 0, graph.add_landmark({0.3, -0.4, 5.0}, submap).id);
    graph.describe(submap);
  }
  const MapLandmark before = graph.landmark(0);
  const Sim3 moved(2.0, SO3::exp({0.3, -0.2, 0.1}), {4.0, 5.0, 6.0});
  graph.transform(1, moved);
  EXPECT_EQ(graph.camera_from_world(0).matrix(), pose.matrix());
  EXPECT_EQ(graph.unit(0), 1.0);
  EXPECT_EQ(graph.landmark(0).position, before.position);
  EXPECT_EQ(graph.landmark(0).max_distance, before.max_distance);
  const MapLandmark& after = graph.landmark(1);
  EXPECT_LT((after.position - moved * before.position).norm(), 1e-12);
  EXPECT_LT((after.direction - moved.rotation() * before.direction).norm(), 1e-12);
  EXPECT_EQ(after.min_distance, 2.0F * before.min_distance);
  EXPECT_EQ(after.max_distance, 2.0F * before.max_distance);
  EXPECT_EQ(graph.unit(1), 2.0);
}

}  // namespace
}  // namespace rastro
