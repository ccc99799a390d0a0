// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/base/time.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Localization in a given map: a pose away from the predicted one that neither a plausible acceleration nor the errors
/// of both poses explain. One of the two is wrong, and what follows agrees with either: the camera is lost until a
/// relocalization is confirmed.
class JumpCheck {
 public:
  /// m/s^2, in the unit of the map; 0: nothing is checked.
  explicit JumpCheck(double max_acceleration) : max_acceleration_(max_acceleration) {}

  /// With every pose that was tracked, in turn. `covariance`: of the pose, translation first (TrackingResult).
  bool jumps(TimeNs stamp, const SE3& predicted, const SE3& camera_from_world, const Matrix6d& covariance);
  /// After a loss.
  void reset() { last_.reset(); }

 private:
  struct Last {
    TimeNs stamp = 0;
    double variance = 0.0;  ///< Of the position, all axes together.
  };
  double max_acceleration_;
  std::optional<Last> last_;
};

}  // namespace rastro
