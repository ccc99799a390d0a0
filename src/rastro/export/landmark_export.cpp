// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/landmark_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "rastro/export/landmark_parts.h"
#include "rastro/map/landmark/essential_graph.h"
#include "rastro/map/landmark/map_scale.h"

namespace rastro {
namespace {

constexpr std::uint8_t unknown_colour = 160;

double sigma_along(const LandmarkMap& map, const Landmark& landmark, const Eigen::Vector3d& direction) {
  const auto covariance = place_covariance(map, landmark);
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

PointCloud landmark_cloud(const LandmarkMap& map, int submap) {
  const LandmarkPart part(map, submap);
  PointCloud cloud;
  for (const Landmark& landmark : map.landmarks) {
    if (!part.first_viewer(landmark)) continue;
    CloudPoint point;
    point.position = landmark.position.cast<float>();
    point.normal = -landmark.direction.cast<float>();
    point.colour = {unknown_colour, unknown_colour, unknown_colour};
    point.count = static_cast<std::uint32_t>(landmark.observations.size());
    point.sigma = static_cast<float>(sigma_along(map, landmark, landmark.direction));
    cloud.points.push_back(point);
  }
  return cloud;
}

std::string landmark_list_csv(const LandmarkMap& map, int submap) {
  const LandmarkPart part(map, submap);
  std::string text = "id,x,y,z,sigma,seen,frame,x_px,y_px\n";
  for (const Landmark& landmark : map.landmarks) {
    const auto viewer = part.first_viewer(landmark);
    if (!viewer) continue;
    const LandmarkKeyframe& keyframe = *map.keyframes[*viewer];
    const auto seen = std::find_if(landmark.observations.begin(), landmark.observations.end(),
                                   [&](const LandmarkObservation& each) { return each.keyframe == keyframe.id; });
    const Keypoint& at = keyframe.features.keypoints[seen->feature];
    const Eigen::Vector3d& p = landmark.position;
    fmt::format_to(std::back_inserter(text), "{},{:.9g},{:.9g},{:.9g},{:.3g},{},{},{:.2f},{:.2f}\n", landmark.id, p.x(),
                   p.y(), p.z(), sigma_along(map, landmark, landmark.direction), landmark.observations.size(),
                   keyframe.frame, at.x, at.y);
  }
  return text;
}

std::string landmark_graph_g2o(const LandmarkMap& map, int submap) {
  const LandmarkPart part(map, submap);
  std::string text = fmt::format("# written by rastro: world_from_camera of keyframes, {}; quaternions x y z w\n",
                                 map.scale.metric ? "metres" : "the map's own unit");
  std::string fixed;
  std::set<int> submaps;
  for (std::size_t k = 0; k < map.poses.size(); ++k) {
    if (!part.has_keyframe(k)) continue;
    fmt::format_to(std::back_inserter(text), "VERTEX_SE3:QUAT {}", map.keyframes[k]->id);
    append_pose(text, map.poses[k].world_from_camera);
    text += '\n';
    if (submaps.insert(map.poses[k].submap).second) fixed += fmt::format("FIX {}\n", map.keyframes[k]->id);
  }
  text += fixed;
  for (const EssentialEdge& edge : essential_graph(map)) {
    if (edge.kind == EssentialKind::tie || !part.has_keyframe(edge.first) || !part.has_keyframe(edge.second)) continue;
    const SE3 first_from_second =
        map.poses[edge.first].world_from_camera.inverse() * map.poses[edge.second].world_from_camera;
    append_edge(text, map.keyframes[edge.first]->id, map.keyframes[edge.second]->id, first_from_second, edge.shared);
  }
  for (const LandmarkTie& tie : map.ties) {
    const auto from = part.places().of(tie.from), to = part.places().of(tie.to);
    if (!from || !to || !part.has_keyframe(*from) || !part.has_keyframe(*to)) continue;
    append_edge(text, tie.from, tie.to, SE3(tie.from_from_to.rotation(), tie.from_from_to.translation()), tie.inliers);
  }
  return text;
}

}  // namespace rastro
