// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/landmark_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "rastro/export/covisible_poses.h"
#include "rastro/export/landmark_parts.h"
#include "rastro/map/graph/covisibility.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"

namespace rastro {
namespace {

/// Along the mean viewing direction; empty: unknown.
std::string sigma_text(const Map& map, const Landmark& landmark) {
  const Eigen::Vector3d& direction = landmark.direction;
  const auto covariance = landmark_covariance(map, landmark);
  const double variance = covariance ? direction.dot(*covariance * direction) : 0.0;
  return variance > 0.0 ? fmt::format("{:.3g}", std::sqrt(variance)) : std::string();
}

Matrix6d by_count(int landmarks) { return Matrix6d::Identity() * (std::max(landmarks, 1) / 100.0); }

/// As the shared landmarks measure it; where they are too few, the poses of the map with little weight.
void append_covisible(std::string& text, const Map& map, const CovisiblePoses& poses, const EssentialEdge& edge) {
  const Keyframe &first = map.keyframes[edge.first], &second = map.keyframes[edge.second];
  if (const auto measured = poses.measure(edge.first, edge.second))
    return g2o::append_edge(text, first.id, second.id, measured->first_from_second, measured->information);
  text += "# the next edge is not measured, but keeps the keyframes as they are\n";
  g2o::append_edge(text, first.id, second.id, first.world_from_camera.inverse() * second.world_from_camera,
                   by_count(edge.shared));
}

/// Loop closure or merge: as it was found then.
void append_closure(std::string& text, const Map& map, const CovisiblePoses& poses, const Constraint& loop_closure) {
  Matrix6d information = loop_closure.information;
  if (information.isIdentity()) {  // the method did not say
    const auto judged =
        poses.judge(*map.index_of(loop_closure.from), *map.index_of(loop_closure.to), loop_closure.rigid());
    information = judged ? judged->information : by_count(loop_closure.inliers);
  }
  g2o::append_edge(text, loop_closure.from, loop_closure.to, loop_closure.rigid(), information);
}

}  // namespace

bool has_observed_landmarks(const Map& map) {
  const auto landmarks = map.layer<LandmarkLayer>();
  return landmarks && landmarks->estimates.empty() && map.layer<FeatureLayer>();
}

std::string landmark_list_csv(const Map& map, int submap) {
  const LandmarkPart part(map, submap);
  std::string text = "id,x,y,z,sigma,seen,frame,x_px,y_px\n";
  for (const Landmark& landmark : part.landmarks()) {
    const LandmarkObservation* first = part.first_observation(landmark);
    const Keypoint* at = first ? part.keypoint_of(*first) : nullptr;
    if (!at) continue;
    const Eigen::Vector3d& p = landmark.position;
    fmt::format_to(std::back_inserter(text), "{},{:.9g},{:.9g},{:.9g},{},{},{},{:.2f},{:.2f}\n", landmark.id, p.x(),
                   p.y(), p.z(), sigma_text(map, landmark), landmark.observations.size(),
                   map.find(first->keyframe)->frame, at->x, at->y);
  }
  return text;
}

std::string landmark_graph_g2o(const Map& map, int submap, GraphSize* size) {
  const LandmarkPart part(map, submap);
  const CovisiblePoses poses(map, submap);
  std::string text = g2o::head(map);
  GraphSize written{g2o::append_vertices(text, map, submap), 0};
  for (const EssentialEdge& edge : essential_graph(map)) {
    if (edge.kind == EssentialKind::constraint) continue;
    if (!part.has_keyframe(edge.first) || !part.has_keyframe(edge.second)) continue;
    append_covisible(text, map, poses, edge);
    ++written.edges;
  }
  for (const Constraint& each : map.constraints) {
    if (each.kind != ConstraintKind::loop && each.kind != ConstraintKind::merge) continue;
    if (!part.index_of(each.from) || !part.index_of(each.to)) continue;
    append_closure(text, map, poses, each);
    ++written.edges;
  }
  if (size) *size = written;
  return text;
}

}  // namespace rastro
