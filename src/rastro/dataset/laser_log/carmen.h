// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "rastro/dataset/laser_log/log_parser.h"

namespace rastro {

/// Scans of a CARMEN log (Montemerlo, Roy, Thrun 2003): FLASER and ROBOTLASER1, whichever comes first in the file.
/// Stamps are the ipc_timestamp of the line, exact. The units are meters and radians.
/// - FLASER: n ranges over 180 degrees from -90. The log does not say the step: 180, 360, ... beams are whole parts of
///   180 degrees (the last one misses), 181, 361, ... reach from end to end. The scanner's pose is PARAM
///   robot_frontlaser_offset (meters forward, default 0): the line's own laser pose may have been corrected by others.
///   Nothing came back at max_range: the largest range of the file where at least one beam in a thousand has exactly
///   it, as scanners write a number of their own for that; else PARAM robot_front_laser_max; else 81.83 (SICK LMS 200).
/// - ROBOTLASER1: the whole geometry stands in the line.
/// Odometry is the robot's pose of the same line; where it is the same in all of the file there is none. Other lines
/// (ODOM, SYNC, RLASER, ROBOTLASER2, ...) are not needed; scans among them are counted in a warning.
class CarmenParser final : public LogParser {
 public:
  std::optional<Frame> read(std::string_view line, const LinePosition& position) override;
  void start_over(SourceInfo& info) override;

 private:
  void read_param(LogWords words);
  Frame read_flaser(LogWords words);
  Frame read_robot_laser(LogWords words);
  void keep_statistics(const LaserScan& scan, const SE2& odometry);

  bool second_pass_ = false;
  std::string kind_;  ///< Of the first scan.
  double laser_offset_ = 0.0;
  double max_range_of_param_ = 0.0;  ///< 0 = not there.
  double max_range_ = 0.0;           ///< Of FLASER; 0 in the first pass.
  bool has_odometry_ = false;
  std::optional<SE2> first_odometry_;
  float largest_range_ = 0.0F;
  std::int64_t largest_range_count_ = 0;
  std::int64_t beam_count_ = 0;
  std::int64_t other_scans_ = 0;
  std::string other_kind_;
};

/// Whether the front of a text looks like a CARMEN log.
bool looks_like_carmen(std::string_view front);

}  // namespace rastro
