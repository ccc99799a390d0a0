// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>

namespace rastro {

/// What odometry may be wrong by along a path of length s: variance (share * s)^2 + variance_per_m * s.
struct OdometryError {
  double share = 0.0;           ///< The same error all the way, such as that of the wheels' size.
  double variance_per_m = 0.0;  ///< Errors that differ from step to step, m^2 per m.
};

/// How far the robot moves where odometry says one meter: in inches, or with wheels of another size, it is not 1.
/// Learned where scans alone tell the motion, for where they do not.
class OdometryScale {
 public:
  /// Motion over the same time by odometry and by scans that see all directions, body frame, meters.
  void add(const Eigen::Vector2d& by_odometry, const Eigen::Vector2d& by_scans);
  /// 1 unless all the last stretches agree on another one.
  double factor() const { return factor_; }
  /// Of odometry with that factor, as all stretches show it; `unknown_share` until they are many.
  OdometryError error(double unknown_share) const;

 private:
  void judge();

  double path_m_ = 0.0, by_odometry_m_ = 0.0;  ///< Lengths of the stretch that is being driven.
  double along_m_ = 0.0;                       ///< Of it by scans, in the direction of odometry.
  std::deque<double> ratios_;                  ///< Of the last stretches.
  std::deque<double> for_error_;               ///< Of more of them.
  double factor_ = 1.0;
};

}  // namespace rastro
