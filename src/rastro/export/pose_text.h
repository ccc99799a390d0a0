// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// The upper 3x4 of each pose, 12 numbers a line; stamps go to kitti_times_text.
std::string kitti_text(const Trajectory& trajectory);
/// Seconds, one stamp a line.
std::string kitti_times_text(const Trajectory& trajectory);
/// "stamp,px,py,pz,qw,qx,qy,qz" a line, nanoseconds.
std::string euroc_text(const Trajectory& trajectory);

}  // namespace rastro
