// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/scale.h"

#include <vector>

#include "rastro/math/alignment.h"

namespace rastro {

std::optional<double> scale_from_reference(const Trajectory& trajectory, const Trajectory& reference) {
  constexpr TimeNs widest = 1'000'000'000;
  std::vector<Eigen::Vector3d> ours, theirs;
  for (const StampedPose& pose : trajectory) {
    const auto there = pose_at(reference, pose.stamp, widest);
    if (!there) continue;
    ours.push_back(pose.world_from_body.translation());
    theirs.push_back(there->translation());
  }
  const auto alignment = align_points(theirs, ours, AlignmentKind::similarity);
  if (!alignment || !(alignment->target_from_source.scale() > 0.0)) return std::nullopt;
  return alignment->target_from_source.scale();
}

void scale_trajectory(Trajectory& trajectory, double factor) {
  if (trajectory.empty()) return;
  const Eigen::Vector3d origin = trajectory.front().world_from_body.translation();
  for (StampedPose& pose : trajectory) {
    const SE3& before = pose.world_from_body;
    pose.world_from_body = SE3(before.rotation(), origin + factor * (before.translation() - origin));
  }
}

double path_length(const Trajectory& trajectory) {
  double length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory[i].world_from_body.translation() - trajectory[i - 1].world_from_body.translation()).norm();
  }
  return length;
}

}  // namespace rastro
