// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// "stamp tx ty tz qx qy qz qw" and a newline, in the TUM format.
std::string tum_line(const StampedPose& pose);

/// Two comment lines: the meaning of the poses, and the columns.
std::string tum_header(std::string_view what);

/// Header and all poses.
std::string trajectory_text(const Trajectory& trajectory, std::string_view what);

}  // namespace rastro
