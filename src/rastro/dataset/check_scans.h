// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>
#include <set>

#include "rastro/dataset/check.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Checks what frames without images bring: scans, wheel odometry, landmarks. Internal to the dataset module.
class ScanCheck {
 public:
  explicit ScanCheck(CheckReport& report) : report_(report) {}

  void add(const Frame& frame);
  /// Shares, jumps and the warnings about them.
  void finish();

 private:
  void check_scan(std::int64_t index, const LaserScan& scan);
  void check_odometry(const Frame& frame);
  void find_jumps();

  struct Step {
    std::int64_t frame = 0;
    double meters = 0.0, radians = 0.0, seconds = 0.0;
  };

  CheckReport& report_;
  std::int64_t beams_ = 0, returns_ = 0, free_ = 0;
  std::optional<SE2> last_odometry_;
  TimeNs last_stamp_ = 0;
  std::vector<Step> steps_;
  std::set<std::int64_t> landmarks_;
};

}  // namespace rastro
