// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/math/se3.h"

namespace rastro {

struct StampedPose {
  TimeNs stamp = 0;
  SE3 world_from_body;  ///< Or of the camera; who holds the trajectory says which.
};

using Trajectory = std::vector<StampedPose>;  ///< In the order of time.

/// Pose at `stamp` between its two neighbours; nullopt outside the trajectory or where the neighbours are farther apart
/// than max_gap.
std::optional<SE3> pose_at(const Trajectory& trajectory, TimeNs stamp, TimeNs max_gap);

}  // namespace rastro
