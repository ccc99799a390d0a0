// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "rastro/map/graph/covisibility.h"
#include "rastro/viewer/scene_parts.h"

namespace rastro::detail {
namespace {

/// In the page's words, as they stand beside one another in its list of layers.
const char* name_of_edges(ConstraintKind kind) {
  switch (kind) {
    case ConstraintKind::odometry:
      return "odometry";
    case ConstraintKind::proximity:
      return "proximity";
    case ConstraintKind::loop:
      return "loops";
    case ConstraintKind::merge:
      return "merges";
    case ConstraintKind::inter_robot:
      return "inter_robot";
  }
  return "constraints";
}

/// Leaves out edges of keyframes that are not shown.
class EdgeList {
 public:
  EdgeList(const SceneJob& job, std::string name) : job_(job) { edges_.name = std::move(name); }

  void add(std::optional<std::uint32_t> from, std::optional<std::uint32_t> to) {
    if (from && to) edges_.pairs.insert(edges_.pairs.end(), {*from, *to});
  }
  void add_ids(KeyframeId from, KeyframeId to) {
    add(job_.rows.row_of(job_.map, from), job_.rows.row_of(job_.map, to));
  }
  void add_indices(std::size_t from, std::size_t to) { add(job_.rows.row(from), job_.rows.row(to)); }
  void move_to(ViewScene& scene) {
    if (!edges_.pairs.empty()) scene.layers.emplace_back(std::move(edges_));
  }

 private:
  const SceneJob& job_;
  SceneEdges edges_;
};

void add_constraints(const SceneJob& job, ViewScene& scene) {
  for (int kind = 0; kind < constraint_kinds; ++kind) {
    EdgeList edges(job, name_of_edges(static_cast<ConstraintKind>(kind)));
    for (const Constraint& each : job.map.constraints)
      if (static_cast<int>(each.kind) == kind) edges.add_ids(each.from, each.to);
    edges.move_to(scene);
  }
}

void add_spanning_tree(const SceneJob& job, ViewScene& scene) {
  EdgeList edges(job, "spanning_tree");
  for (const Keyframe& keyframe : job.map.keyframes)
    if (keyframe.parent != no_keyframe) edges.add_ids(keyframe.parent, keyframe.id);
  edges.move_to(scene);
}

}  // namespace

void add_graphs(const SceneJob& job, ViewScene& scene) {
  add_constraints(job, scene);
  add_spanning_tree(job, scene);
  const auto covisible = covisibility_graph(job.map, job.options.covisible);
  EdgeList covisibility(job, "covisibility");
  for (const Covisibility& each : covisible) covisibility.add_indices(each.first, each.second);
  covisibility.move_to(scene);
  // Without landmarks it would be the constraints and the spanning tree once more.
  if (covisible.empty()) return;
  EdgeList essential(job, "essential_graph");
  for (const EssentialEdge& each : essential_graph(job.map)) essential.add_indices(each.first, each.second);
  essential.move_to(scene);
}

}  // namespace rastro::detail
