// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/base/time.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/laser_scan.h"

namespace rastro {

/// Scans as a CARMEN log: this header once, then a line of carmen_robot_laser_line() a scan. open() reads it back.
std::string carmen_header();

/// What stands for "nothing came back": the smallest float not below max_range. The nearest one might be below it, and
/// would then be taken for a return.
float free_range(double max_range);

/// One ROBOTLASER1 line with its newline and the whole geometry: digits enough that what every beam says, the stamp,
/// the angles and the odometry read back exactly (body_from_laser within rounding). A broken beam is written as 0;
/// without odometry give the identity for every scan: where nothing ever moves, readers take it that there is none.
/// A promise of the caller: angles, max_range and poses are finite.
std::string carmen_robot_laser_line(const LaserScan& scan, const SE2& odometry_from_body, TimeNs stamp);

}  // namespace rastro
