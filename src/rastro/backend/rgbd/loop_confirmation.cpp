// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/loop_confirmation.h"

namespace rastro {
namespace {

constexpr double most_path_m = 15.0;                         // between the two
constexpr std::int64_t most_keyframes = 200;                 // likewise
constexpr double least_apart_m = 4.0;                        // of the evidence: more than a door and its frame
constexpr double max_distance_m = 0.5, max_angle_rad = 0.1;  // between the corrections, where the camera is

/// How it would move the submap of its newer keyframe.
SE3 correction_of(const KeyframeGraph& graph, const Constraint& edge) {
  return graph.pose(edge.from) * edge.rigid() * graph.pose(edge.to).inverse();
}

bool connect_the_same(const KeyframeGraph& graph, const Constraint& a, const Constraint& b) {
  return graph.submap(a.from) == graph.submap(b.from) && graph.submap(a.to) == graph.submap(b.to);
}

bool agree(const KeyframeGraph& graph, const LoopHypothesis& a, const LoopHypothesis& b) {
  if (!connect_the_same(graph, a.edge, b.edge)) return false;
  const Eigen::Vector3d from_a = graph.pose(a.edge.to) * a.evidence, from_b = graph.pose(b.edge.to) * b.evidence;
  if ((from_a - from_b).norm() < least_apart_m) return false;
  const SE3 moved_a = correction_of(graph, a.edge), moved_b = correction_of(graph, b.edge);
  const Eigen::Vector3d& at = graph.pose(b.edge.to).translation();
  return (moved_a * at - moved_b * at).norm() <= max_distance_m &&
         (moved_a.rotation().inverse() * moved_b.rotation()).log().norm() <= max_angle_rad;
}

}  // namespace

std::vector<Constraint> LoopConfirmation::next(const KeyframeGraph& graph, const LoopHypothesis& newest) {
  std::vector<Constraint> confirmed;
  std::vector<LoopHypothesis> left;
  for (const LoopHypothesis& earlier : waiting_) {
    if (newest.edge.to - earlier.edge.to > most_keyframes) continue;
    if (graph.path_between(earlier.edge.to, newest.edge.to) > most_path_m) continue;
    if (agree(graph, earlier, newest))
      confirmed.push_back(earlier.edge);
    else
      left.push_back(earlier);
  }
  if (!confirmed.empty()) {
    confirmed.push_back(newest.edge);
  } else {
    left.push_back(newest);
  }
  waiting_ = std::move(left);
  return confirmed;
}

}  // namespace rastro
