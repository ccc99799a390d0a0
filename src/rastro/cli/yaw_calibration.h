// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/sensor/trajectory.h"

namespace rastro::cli {

/// What `rastro odometry --method profiles --calibrate-yaw` prints: the radians per pixel of shift that fit the
/// reference best. `trajectory` was made with `lambda_rad_px`. Error where the two share too few rotations.
std::string yaw_calibration_report(const Trajectory& trajectory, const Trajectory& reference, double lambda_rad_px);

}  // namespace rastro::cli
