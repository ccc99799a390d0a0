// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "rastro/slam/ekf/association.h"
#include "rastro/slam/ekf/frozen_odometry.h"
#include "rastro/slam/ekf/motion_model.h"
#include "rastro/slam/ekf/odometry_check.h"
#include "rastro/slam/ekf/options.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// The body's motion from frame to frame, as wheel odometry tells it; where that is missing, jumps or is frozen, as far
/// as it can be known.
class BodyMotion {
 public:
  explicit BodyMotion(const EkfOptions& options) : options_(options) {}

  /// Of each frame, first: the motion since the previous one, in the previous body frame. None at the first frame, nor
  /// while odometry is frozen.
  Motion since_last(const Frame& frame, SlamUpdate& update);
  /// The first frame, the only one so far, was at this time: its stamp was wrong.
  void begin_at(TimeNs stamp);
  /// Odometry stays the same while the body moves, see FrozenOdometry; known before this frame's landmarks.
  bool frozen() const { return frozen_.frozen(); }
  /// The same with the associations of this frame, made as if odometry told the motion.
  bool is_frozen(std::span<const LandmarkAssociation> associations, SlamUpdate& update);
  /// Frozen, and no landmark is believed any more.
  bool lost() const { return frozen_.lost(); }
  /// While odometry is frozen: the motion that the filter was not told of. From then on it counts as told.
  Motion unknown();
  /// Covariance of (x, y, angle) of that motion.
  Eigen::Matrix3d unknown_covariance() const;
  /// Of each frame, last. `corrected`: with a landmark.
  void end_frame(const Frame& frame, std::span<const LandmarkAssociation> associations, const SE2& world_from_body,
                 bool corrected);

  OdometryCheck::Result odometry_error() const { return check_.result(); }

 private:
  Motion by_odometry(const SE2& last_from_body, double seconds, SlamUpdate& update);
  Motion after_frozen(const SE2& last_from_body, SlamUpdate& update);
  Motion carried(double seconds);
  double unknown_until() const;

  EkfOptions options_;
  FrozenOdometry frozen_;
  OdometryCheck check_;

  std::optional<TimeNs> stamp_;  ///< Of the last frame; nothing before the first.
  std::optional<SE2> odometry_;  ///< Nothing where that frame had none.
  SE2 motion_;                   ///< The last that odometry told, over `seconds_`.
  double seconds_ = 0.0;

  double unknown_s_ = 0.0;  ///< Time in which nothing told the motion, as far as the filter knows of it.
  Eigen::Matrix3d not_told_ = Eigen::Matrix3d::Zero();  ///< What it did not know after the last frame.
};

}  // namespace rastro
