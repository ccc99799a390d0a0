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

void append_constraint(std::string& text, const Constraint& constraint) {
  if (!(constraint.weight > 0.0)) text += "# switched off: ";
  fmt::format_to(std::back_inserter(text), "EDGE_SE3:QUAT {} {}", constraint.from, constraint.to);
  append_pose(text, constraint.rigid());
  const double weight = constraint.weight > 0.0 ? constraint.weight : 1.0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      const double scale = weight * (row >= 3 ? 2.0 : 1.0) * (column >= 3 ? 2.0 : 1.0);
      fmt::format_to(std::back_inserter(text), " {:.9g}", scale * constraint.information(row, column));
    }
  }
  text += '\n';
}

}  // namespace

std::string pose_graph_g2o(const Map& map) {
  std::string text = "# written by rastro: world_from_camera of keyframes, metres; quaternions x y z w\n";
  for (const Keyframe& keyframe : map.keyframes) {
    fmt::format_to(std::back_inserter(text), "VERTEX_SE3:QUAT {}", keyframe.id);
    append_pose(text, keyframe.world_from_camera);
    text += '\n';
  }
  std::set<int> submaps;
  for (const Keyframe& keyframe : map.keyframes)
    if (submaps.insert(keyframe.submap).second) fmt::format_to(std::back_inserter(text), "FIX {}\n", keyframe.id);
  for (const Constraint& constraint : map.constraints) append_constraint(text, constraint);
  return text;
}

}  // namespace rastro
