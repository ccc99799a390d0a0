// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "rastro/input_check/input_warning.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Checks observations of landmarks with ids against wheel odometry: does a landmark come nearer by as much as the
/// wheels moved? Ranges and odometry in different units fit a map that is as wrong.
class LandmarkCheck {
 public:
  /// Adds what is sure since this frame to `found`, once.
  void add(const Frame& frame, InputWarnings& found);

 private:
  struct Observation {
    SE2 odometry_from_body;
    Eigen::Vector2d in_body;  ///< Meters.
  };

  void compare(std::int64_t id, const Observation& now);
  void judge(InputWarnings& found);

  std::map<std::int64_t, Observation> first_;  ///< By id, since the last comparison.
  std::vector<double> ratios_;                 ///< Motion against the landmark / by odometry.
  bool told_ = false;
};

}  // namespace rastro
