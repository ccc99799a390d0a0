// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/trajectory.h"

#include <algorithm>

namespace rastro {

std::optional<SE3> pose_at(const Trajectory& trajectory, TimeNs stamp, TimeNs max_gap) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp,
                                      [](const StampedPose& pose, TimeNs time) { return pose.stamp < time; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp == stamp) return after->world_from_body;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = after - 1;
  // Unsigned: the difference of two ordered int64 stamps always fits.
  const auto gap = static_cast<std::uint64_t>(after->stamp) - static_cast<std::uint64_t>(before->stamp);
  if (max_gap < 0 || gap > static_cast<std::uint64_t>(max_gap)) return std::nullopt;
  const double fraction = static_cast<double>(stamp - before->stamp) / static_cast<double>(gap);
  return interpolate(before->world_from_body, after->world_from_body, fraction);
}

}  // namespace rastro
