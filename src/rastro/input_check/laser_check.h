// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/input_check/input_warning.h"
#include "rastro/input_check/scan_motion.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Checks laser scans against wheel odometry: is the scan stuck while the wheels move, and does the motion between
/// scans have the direction and length of the odometry's? Without odometry only their unit is checked.
class LaserCheck {
 public:
  /// Adds what is sure since this frame to `found`, each kind once.
  void add(const Frame& frame, InputWarnings& found);

 private:
  /// Pairs of scans by how their motion compares with odometry's.
  struct Tally {
    int same = 0, opposite = 0;
    std::int64_t met = 0;  ///< Motions long enough, compared or not.
    /// Whether this one is compared: all at first, then every 4th, then every 16th.
    bool take();
    bool reversed(int least) const { return opposite >= least && opposite >= 5 * same; }
  };
  struct Reference {
    ScanMotion scan;
    SE2 odometry_from_body;
  };

  void check_unit(const Frame& frame, InputWarnings& found);
  void check_stuck(const Frame& frame, InputWarnings& found);
  void compare_motion(const Frame& frame);
  void count(const SE2& by_odometry, const ScanMotionFit& by_scans);
  void judge(InputWarnings& found);
  void judge_direction(InputWarnings& found);
  void judge_scale(InputWarnings& found);

  std::vector<float> last_ranges_;
  SE2 odometry_at_change_;
  std::int64_t repeats_ = 0, first_repeated_ = 0;
  bool stuck_ = false, direction_wrong_ = false, scale_wrong_ = false;
  int scans_too_far_ = 0;
  bool unit_wrong_ = false;
  std::optional<Reference> reference_;
  Tally yaw_, forward_;
  std::vector<double> ratios_;  ///< Length by the scans / by odometry, along odometry's direction.
};

}  // namespace rastro
