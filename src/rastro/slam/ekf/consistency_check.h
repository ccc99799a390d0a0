// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "rastro/slam/ekf/motion_model.h"

namespace rastro {

/// Notices that the filter moves against odometry by more than the settings explain: odometry is worse than they say,
/// or landmarks are mistaken for others. Compared are stretches of the path that begin and end with a landmark. If all
/// standard deviations, of odometry and of landmarks, are f times as large as set, the filter's gains and poses are the
/// same, and its own standard deviations are f times as large.
class ConsistencyCheck {
 public:
  /// Of each frame, first: the motion since the previous one as odometry tells it with its estimated scale, and its
  /// covariance by the settings.
  void move(const Motion& motion);
  /// The motion is not known: a new stretch begins.
  void interrupt() { start_.reset(); }
  /// Of each frame, last: the pose by the filter. `told`: by landmarks.
  void end_frame(const SE2& world_from_body, bool told);

  /// By this the filter's standard deviations are too small; 1: consistent. It stays, since a filter does not revise.
  double factor() const { return factor_; }

 private:
  void compare(const SE2& start_from_body);

  std::optional<SE2> start_;  ///< world_from_body where the stretch began.
  Motion odometry_;           ///< Since then.
  double path_m_ = 0.0, path_rad_ = 0.0;
  /// Squared differences of the last stretches over their variances.
  std::deque<double> along_path_, yaw_;
  double factor_ = 1.0;
};

}  // namespace rastro
