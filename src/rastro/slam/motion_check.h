// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/slam/slam.h"

namespace rastro {

/// Tells poses that only an acceleration explains that hardly any camera is exposed to: few features, motion blur and
/// depth errors move single poses by centimeters, with measurements enough to call them tracking.
class MotionCheck {
 public:
  /// m/s^2; 0: nothing is checked.
  explicit MotionCheck(double max_acceleration) : max_acceleration_(max_acceleration) {}

  /// With every update in turn, in meters. One that contradicts the two before it becomes weak, for
  /// SlamReason::implausible_motion. After a loss or a gap the history begins anew.
  void check(SlamUpdate& update);
  /// Before an update whose map was corrected under the camera, by an unknown step: the history begins anew.
  void forget() { last_.reset(); }
  /// Before an update whose map was corrected under the camera, where poses of before are new_from_old times what they
  /// were: the step is no motion.
  void follow(const SE3& new_from_old);

 private:
  struct Last {
    TimeNs stamp;
    Eigen::Vector3d position;
    std::optional<Eigen::Vector3d> velocity;
  };
  double max_acceleration_;
  std::optional<Last> last_;
};

/// Whether one of these corrected the map under the camera.
bool corrects_map(const std::vector<SlamEvent>& events);

}  // namespace rastro
