// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/slam/slam.h"

namespace rastro {

/// Tells poses that only an acceleration explains that hardly any camera is exposed to: few features, motion blur and
/// depth errors move single poses by centimeters, with measurements enough to call them tracking.
class MotionCheck {
 public:
  /// m/s^2; 0: nothing is checked.
  explicit MotionCheck(double max_acceleration) : max_acceleration_(max_acceleration) {}

  /// With every update in turn, in meters. One that contradicts the two before it becomes weak, for
  /// SlamReason::implausible_motion. After a loss, a gap or a correction of the map, the history begins anew.
  void check(SlamUpdate& update);

 private:
  struct Last {
    TimeNs stamp;
    Eigen::Vector3d position;
    std::optional<Eigen::Vector3d> velocity;
  };
  double max_acceleration_;
  std::optional<Last> last_;
};

}  // namespace rastro
