// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/pose_text.h"

#include <fmt/format.h>

#include <iterator>

#include "rastro/sensor/stamp_text.h"

namespace rastro {

std::string kitti_text(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& pose : trajectory) {
    const Eigen::Matrix4d matrix = pose.world_from_body.matrix();
    for (int k = 0; k < 12; ++k)
      fmt::format_to(std::back_inserter(text), "{:.9e}{}", matrix(k / 4, k % 4), k == 11 ? '\n' : ' ');
  }
  return text;
}

std::string kitti_times_text(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& pose : trajectory) text += seconds_text(pose.stamp) + "\n";
  return text;
}

std::string euroc_text(const Trajectory& trajectory) {
  std::string text = "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  for (const auto& [stamp, pose] : trajectory) {
    const Eigen::Vector3d& p = pose.translation();
    const Eigen::Quaterniond& q = pose.rotation().quaternion();
    fmt::format_to(std::back_inserter(text), "{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}\n", stamp, p.x(),
                   p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
  }
  return text;
}

}  // namespace rastro
