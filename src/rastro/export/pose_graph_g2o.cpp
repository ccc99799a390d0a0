// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/pose_graph_g2o.h"

#include <fmt/format.h>

#include <iterator>
#include <set>

namespace rastro {
namespace {

void append_pose(std::string& text, const SE3& pose) {
  const Eigen::Vector3d& p = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation().quaternion();
  fmt::format_to(std::back_inserter(text), " {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}", p.x(), p.y(), p.z(),
                 q.x(), q.y(), q.z(), q.w());
}

void append_edge(std::string& text, const PoseEdge& edge) {
  if (!(edge.weight > 0.0)) text += "# switched off: ";
  fmt::format_to(std::back_inserter(text), "EDGE_SE3:QUAT {} {}", edge.from, edge.to);
  append_pose(text, edge.from_from_to);
  const double weight = edge.weight > 0.0 ? edge.weight : 1.0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      const double scale = weight * (row >= 3 ? 2.0 : 1.0) * (column >= 3 ? 2.0 : 1.0);
      fmt::format_to(std::back_inserter(text), " {:.9g}", scale * edge.information(row, column));
    }
  }
  text += '\n';
}

}  // namespace

std::string pose_graph_g2o(const RgbdMap& map) {
  std::string text = "# written by rastro: world_from_camera of keyframes, metres; quaternions x y z w\n";
  for (std::size_t k = 0; k < map.poses.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "VERTEX_SE3:QUAT {}", k);
    append_pose(text, map.poses[k].world_from_camera);
    text += '\n';
  }
  std::set<int> submaps;
  for (std::size_t k = 0; k < map.poses.size(); ++k)
    if (submaps.insert(map.poses[k].submap).second) fmt::format_to(std::back_inserter(text), "FIX {}\n", k);
  for (const PoseEdge& edge : map.edges) append_edge(text, edge);
  return text;
}

}  // namespace rastro
