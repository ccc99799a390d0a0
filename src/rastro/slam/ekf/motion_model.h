// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/math/se2.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {

/// A motion since the frame before, in the body frame of then, with the covariance of (x, y, angle).
struct Motion {
  SE2 last_from_body;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// What odometry said, as uncertain as the options call it. Variances grow with way and turn, so that it makes no
/// difference in how many steps a way is told.
Motion measured_motion(const SE2& last_from_body, const EkfOptions& options);

/// Without odometry: on with the last velocity, over a time in seconds, and in great doubt.
Motion carried_motion(const SE2& last_motion, double last_seconds, double seconds, const EkfOptions& options);

/// No vehicle that the options allow moves like this in so many seconds; true for numbers that are not finite.
bool is_jump(const SE2& last_from_body, double seconds, const EkfOptions& options);

}  // namespace rastro
