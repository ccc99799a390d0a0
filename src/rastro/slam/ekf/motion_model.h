// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/math/se2.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {

/// The motion since the previous frame, in the previous body frame, with the covariance of (x, y, angle).
struct Motion {
  SE2 last_from_body;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  bool measured = false;  ///< By odometry; else assumed.
};

/// The motion measured by odometry, with the noise of the options. Variances grow linearly with path length and
/// rotation, so the result does not depend on the number of steps.
Motion measured_motion(const SE2& last_from_body, const EkfOptions& options);

/// A pause longer than this is as uncertain as this: the body has rather stopped than gone on.
inline constexpr double longest_pause_s = 10.0;

/// Without odometry: constant velocity over `seconds`, after `unknown_seconds` in which nothing told the motion either.
Motion carried_motion(const SE2& last_motion, double last_seconds, double seconds, const EkfOptions& options,
                      double unknown_seconds = 0.0);

/// Covariance of (x, y, angle) that motion gains between these numbers of seconds without odometry or landmark. Speed
/// and yaw rate are wrong by one value that lasts for ten seconds, so it does not depend on the number of frames.
Eigen::Matrix3d unknown_covariance(double from_seconds, double to_seconds, const EkfOptions& options);

/// Whether the motion exceeds the speed limits of the options over `seconds`; true for values that are not finite.
bool is_jump(const SE2& last_from_body, double seconds, const EkfOptions& options);

}  // namespace rastro
