// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// "stamp tx ty tz qx qy qz qw" with its newline, as the TUM benchmark writes poses.
std::string tum_line(const StampedPose& pose);

/// Two lines of comment: what the poses are, and the columns.
std::string tum_header(std::string_view what);

/// Header and all poses.
std::string trajectory_text(const Trajectory& trajectory, std::string_view what);

}  // namespace rastro
