// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/loop_confirmation.h"

namespace rastro {
namespace {

constexpr double most_path_m = 15.0;                         // between the two
constexpr std::int64_t most_keyframes = 200;                 // likewise
constexpr double least_apart_m = 4.0;                        // of the evidence: more than a door and its frame
constexpr double max_distance_m = 0.5, max_angle_rad = 0.1;  // between the corrections, where the camera is and was
constexpr double predicted_m = 0.3, predicted_rad = 0.1;     // as near is what the map predicts

/// How it would move the submap of its newer keyframe.
SE3 correction_of(const KeyframeGraph& graph, const Constraint& edge) {
  return graph.pose(edge.from) * edge.rigid() * graph.pose(edge.to).inverse();
}

bool connect_the_same(const KeyframeGraph& graph, const Constraint& a, const Constraint& b) {
  return graph.submap(a.from) == graph.submap(b.from) && graph.submap(a.to) == graph.submap(b.to);
}

/// What both would do to the camera of keyframe `at`.
double distance_between(const KeyframeGraph& graph, const SE3& moved_a, const SE3& moved_b, std::int64_t at) {
  const Eigen::Vector3d& position = graph.pose(at).translation();
  return (moved_a * position - moved_b * position).norm();
}

/// An image of a row of windows is off by the same step in each of the keyframes that saw the row.
bool agree(const KeyframeGraph& graph, const LoopHypothesis& a, const LoopHypothesis& b) {
  if (a.edge.to == b.edge.to || !connect_the_same(graph, a.edge, b.edge)) return false;
  const Eigen::Vector3d from_a = graph.pose(a.edge.to) * a.evidence, from_b = graph.pose(b.edge.to) * b.evidence;
  if ((from_a - from_b).norm() < least_apart_m) return false;
  const SE3 moved_a = correction_of(graph, a.edge), moved_b = correction_of(graph, b.edge);
  // Corrections that differ by a rotation about one end of the path between agree there, and there alone.
  return distance_between(graph, moved_a, moved_b, a.edge.to) <= max_distance_m &&
         distance_between(graph, moved_a, moved_b, b.edge.to) <= max_distance_m &&
         (moved_a.rotation().inverse() * moved_b.rotation()).log().norm() <= max_angle_rad;
}

}  // namespace

bool agrees_with_map(const SE3& predicted, const SE3& measured) {
  const SE3 off = predicted.inverse() * measured;
  return off.translation().norm() <= predicted_m && off.rotation().log().norm() <= predicted_rad;
}

std::vector<Constraint> LoopConfirmation::next(const KeyframeGraph& graph, const LoopHypothesis& newest,
                                               const Fits& still_fits) {
  std::vector<Constraint> confirmed;
  std::vector<LoopHypothesis> left;
  for (const LoopHypothesis& earlier : waiting_) {
    if (newest.edge.to - earlier.edge.to > most_keyframes) continue;
    if (graph.path_between(earlier.edge.to, newest.edge.to) > most_path_m) continue;
    if (!agree(graph, earlier, newest))
      left.push_back(earlier);
    else if (still_fits(earlier.edge))
      confirmed.push_back(earlier.edge);
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
