// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>

namespace rastro {

/// How far the robot moves where odometry says one meter: in inches, or with wheels of another size, it is not 1.
/// Learned where scans alone tell the motion, for where they do not.
class OdometryScale {
 public:
  /// Motion over the same time by odometry and by scans that see all directions, body frame, meters.
  void add(const Eigen::Vector2d& by_odometry, const Eigen::Vector2d& by_scans);
  /// 1 unless all the last stretches agree on another one.
  double factor() const { return factor_; }

 private:
  void judge();

  double path_m_ = 0.0, along_ = 0.0, squared_ = 0.0;  ///< Of the stretch that is being driven.
  std::deque<double> ratios_;                          ///< Of the last stretches.
  double factor_ = 1.0;
};

}  // namespace rastro
