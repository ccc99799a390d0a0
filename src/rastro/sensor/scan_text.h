// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/base/time.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/laser_scan.h"

namespace rastro {

/// Scans as a CARMEN log: this header once, then one carmen_robot_laser_line() per scan. open() reads it back.
std::string carmen_header();

/// Value for "no return": the smallest float not below max_range. The nearest float might be below it, and would then
/// be read as a return.
float free_range(double max_range);

/// One ROBOTLASER1 line with its newline and the whole geometry. It has enough digits to read back ranges, stamp,
/// angles and odometry exactly (body_from_laser within rounding). A broken beam is written as 0. Without odometry give
/// the identity for every scan: readers take poses that never change as no odometry. Precondition: angles, max_range
/// and poses are finite.
std::string carmen_robot_laser_line(const LaserScan& scan, const SE2& odometry_from_body, TimeNs stamp);

}  // namespace rastro
