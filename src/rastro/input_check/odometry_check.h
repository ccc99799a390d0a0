// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/input_check/input_warning.h"
#include "rastro/input_check/scan_motion.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Checks wheel odometry: is it in meters, and does it stand still while the scans move?
class OdometryCheck {
 public:
  /// Adds what is sure since this frame to `found`, each kind once.
  void add(const Frame& frame, InputWarnings& found);

 private:
  void check_speed(const Frame& frame, InputWarnings& found);
  void check_still(const Frame& frame, InputWarnings& found);
  bool moved_clearly(const LaserScan& scan);

  std::vector<double> speeds_;  ///< m/s, of the first steps that moved.
  std::optional<SE2> last_;
  TimeNs last_stamp_ = 0;
  std::optional<ScanMotion> still_scan_;  ///< Soon after the odometry moved last.
  TimeNs still_since_ = 0;
  std::int64_t first_still_ = 0;
  int still_frames_ = 0;                    ///< Scans since then.
  int still_moved_ = 0;                     ///< Comparisons in a row that moved clearly.
  double moved_m_ = 0.0, moved_rad_ = 0.0;  ///< In the last one.
  bool told_still_ = false;
};

}  // namespace rastro
