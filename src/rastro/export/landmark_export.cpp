// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/landmark_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "rastro/export/landmark_parts.h"
#include "rastro/map/graph/covisibility.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"

namespace rastro {
namespace {

/// Along the mean viewing direction; 0: not known.
double sigma_of(const Map& map, const Landmark& landmark) {
  const Eigen::Vector3d& direction = landmark.direction;
  const auto covariance = landmark_covariance(map, landmark);
  const double variance = covariance ? direction.dot(*covariance * direction) : 0.0;
  return variance > 0.0 ? std::sqrt(variance) : 0.0;
}

void append_pose(std::string& text, const SE3& pose) {
  const Eigen::Vector3d& p = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation().quaternion();
  fmt::format_to(std::back_inserter(text), " {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}", p.x(), p.y(), p.z(),
                 q.x(), q.y(), q.z(), q.w());
}

void append_edge(std::string& text, std::int64_t from, std::int64_t to, const SE3& from_from_to, int shared) {
  fmt::format_to(std::back_inserter(text), "EDGE_SE3:QUAT {} {}", from, to);
  append_pose(text, from_from_to);
  const double weight = std::max(shared, 1) / 100.0;
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column)
      fmt::format_to(std::back_inserter(text), " {:.9g}", row == column ? weight : 0.0);
  text += '\n';
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
    fmt::format_to(std::back_inserter(text), "{},{:.9g},{:.9g},{:.9g},{:.3g},{},{},{:.2f},{:.2f}\n", landmark.id, p.x(),
                   p.y(), p.z(), sigma_of(map, landmark), landmark.observations.size(),
                   map.find(first->keyframe)->frame, at->x, at->y);
  }
  return text;
}

std::string landmark_graph_g2o(const Map& map, int submap) {
  const LandmarkPart part(map, submap);
  std::string text = fmt::format("# written by rastro: world_from_camera of keyframes, {}; quaternions x y z w\n",
                                 scale_of(map).metric ? "metres" : "the map's own unit");
  std::string fixed;
  std::set<int> submaps;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    if (!part.has_keyframe(k)) continue;
    fmt::format_to(std::back_inserter(text), "VERTEX_SE3:QUAT {}", keyframe.id);
    append_pose(text, keyframe.world_from_camera);
    text += '\n';
    if (submaps.insert(keyframe.submap).second) fixed += fmt::format("FIX {}\n", keyframe.id);
  }
  text += fixed;
  for (const EssentialEdge& edge : essential_graph(map)) {
    if (edge.kind == EssentialKind::constraint) continue;
    if (!part.has_keyframe(edge.first) || !part.has_keyframe(edge.second)) continue;
    const Keyframe &first = map.keyframes[edge.first], &second = map.keyframes[edge.second];
    append_edge(text, first.id, second.id, first.world_from_camera.inverse() * second.world_from_camera, edge.shared);
  }
  for (const Constraint& each : map.constraints) {
    if (each.kind != ConstraintKind::loop && each.kind != ConstraintKind::merge) continue;
    if (!part.index_of(each.from) || !part.index_of(each.to)) continue;
    append_edge(text, each.from, each.to, each.rigid(), each.inliers);
  }
  return text;
}

}  // namespace rastro
