// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/g2o_text.h"

#include <fmt/format.h>

#include <iterator>
#include <set>

namespace rastro::g2o {
namespace {

void append_pose(std::string& text, const SE3& pose) {
  const Eigen::Vector3d& p = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation().quaternion();
  fmt::format_to(std::back_inserter(text), " {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}", p.x(), p.y(), p.z(),
                 q.x(), q.y(), q.z(), q.w());
}

}  // namespace

std::string head(const Map& map) {
  return fmt::format("# written by rastro: world_from_camera of keyframes, {}; quaternions x y z w\n",
                     scale_of(map).metric ? "meters" : "arbitrary units");
}

std::size_t append_vertices(std::string& text, const Map& map, int submap) {
  std::string fixed;
  std::set<int> submaps;
  std::size_t count = 0;
  for (const Keyframe& keyframe : map.keyframes) {
    if (submap >= 0 && keyframe.submap != submap) continue;
    ++count;
    fmt::format_to(std::back_inserter(text), "VERTEX_SE3:QUAT {}", keyframe.id);
    append_pose(text, keyframe.world_from_camera);
    text += '\n';
    if (submaps.insert(keyframe.submap).second) fmt::format_to(std::back_inserter(fixed), "FIX {}\n", keyframe.id);
  }
  text += fixed;
  return count;
}

void append_edge(std::string& text, KeyframeId from, KeyframeId to, const SE3& from_from_to,
                 const Matrix6d& information) {
  fmt::format_to(std::back_inserter(text), "EDGE_SE3:QUAT {} {}", from, to);
  append_pose(text, from_from_to);
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      const double scale = (row >= 3 ? 2.0 : 1.0) * (column >= 3 ? 2.0 : 1.0);
      fmt::format_to(std::back_inserter(text), " {:.9g}", scale * information(row, column));
    }
  }
  text += '\n';
}

}  // namespace rastro::g2o
