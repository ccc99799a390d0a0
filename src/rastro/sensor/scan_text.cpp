// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/scan_text.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

void append_range(std::string& line, const LaserScan& scan, std::size_t beam) {
  const auto end = std::back_inserter(line);
  const float range = scan.ranges[beam];
  if (scan.is_free(beam)) {
    fmt::format_to(end, " {}", free_range(scan.max_range));
  } else if (!scan.is_return(beam)) {
    line += " 0";
  } else if (range == static_cast<float>(scan.max_range)) {
    // With a float's digits it would read as max_range itself.
    fmt::format_to(end, " {}", static_cast<double>(range));
  } else {
    fmt::format_to(end, " {}", range);
  }
}

void append_pose(std::string& line, const SE2& pose) {
  fmt::format_to(std::back_inserter(line), " {} {} {}", pose.translation().x(), pose.translation().y(),
                 pose.rotation().angle());
}

}  // namespace

float free_range(double max_range) {
  const auto nearest = static_cast<float>(max_range);
  return static_cast<double>(nearest) >= max_range ? nearest
                                                   : std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

std::string carmen_header() {
  return "# CARMEN log\n"
         "# ROBOTLASER1 laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode "
         "num_readings [range_readings] num_remissions [remission values] laser_pose_x laser_pose_y laser_pose_theta "
         "robot_pose_x robot_pose_y robot_pose_theta laser_tv laser_rv forward_safety_dist side_safety_dist turn_axis "
         "ipc_timestamp ipc_hostname logger_timestamp\n";
}

std::string carmen_robot_laser_line(const LaserScan& scan, const SE2& odometry_from_body, TimeNs stamp) {
  RASTRO_CHECK(std::isfinite(scan.max_range) && std::isfinite(scan.first_angle) && std::isfinite(scan.angle_step),
               "a scan's geometry must be finite");
  const auto beams = scan.ranges.size();
  const double span = beams < 2 ? 0.0 : static_cast<double>(beams - 1) * scan.angle_step;
  std::string line = fmt::format("ROBOTLASER1 0 {} {} {} {} 0.01 0 {}", scan.first_angle, span, scan.angle_step,
                                 scan.max_range, beams);
  for (std::size_t beam = 0; beam < beams; ++beam) append_range(line, scan, beam);
  line += " 0";
  append_pose(line, odometry_from_body * scan.body_from_laser);
  append_pose(line, odometry_from_body);
  const auto seconds = seconds_text(stamp);
  fmt::format_to(std::back_inserter(line), " 0 0 0 0 0 {} rastro {}\n", seconds, seconds);
  return line;
}

}  // namespace rastro
