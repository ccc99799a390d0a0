// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/trajectory_text.h"

#include <fmt/format.h>

#include "rastro/sensor/stamp_text.h"

namespace rastro {

std::string tum_line(const StampedPose& pose) {
  const Eigen::Vector3d& t = pose.world_from_body.translation();
  const Eigen::Quaterniond& q = pose.world_from_body.rotation().quaternion();
  return fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", seconds_text(pose.stamp), t.x(), t.y(),
                     t.z(), q.x(), q.y(), q.z(), q.w());
}

std::string tum_header(std::string_view what) { return fmt::format("# {}\n# stamp tx ty tz qx qy qz qw\n", what); }

std::string trajectory_text(const Trajectory& trajectory, std::string_view what) {
  std::string text = tum_header(what);
  for (const StampedPose& pose : trajectory) text += tum_line(pose);
  return text;
}

}  // namespace rastro
