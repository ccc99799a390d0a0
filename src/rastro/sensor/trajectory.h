// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/math/se3.h"

namespace rastro {

struct StampedPose {
  TimeNs stamp = 0;
  SE3 world_from_body;  ///< Or of the camera, as the owner of the trajectory documents.
};

using Trajectory = std::vector<StampedPose>;  ///< In the order of time.

/// Pose at `stamp`, interpolated between its two neighbors; nullopt outside the trajectory or if the neighbors are
/// farther apart than max_gap.
std::optional<SE3> pose_at(const Trajectory& trajectory, TimeNs stamp, TimeNs max_gap);

}  // namespace rastro
