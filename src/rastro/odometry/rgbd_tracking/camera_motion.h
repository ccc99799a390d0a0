// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/base/time.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Pose and velocity of a camera, from its last two poses.
class CameraMotion {
 public:
  /// world_from_camera of the last frame.
  const SE3& pose() const { return pose_; }
  /// Per second, in the camera.
  const Vector6d& velocity() const { return velocity_; }

  SE3 predicted(TimeNs stamp) const { return pose_ * SE3::exp(velocity_ * to_seconds(stamp - stamp_)); }

  /// The velocity that leads to this pose; zero where there is none before.
  Vector6d velocity_to(TimeNs stamp, const SE3& pose) const {
    const double seconds = to_seconds(stamp - stamp_);
    if (!has_pose_ || seconds <= 0.0) return Vector6d::Zero();
    return (pose_.inverse() * pose).log() / seconds;
  }

  void note(TimeNs stamp, const SE3& pose) {
    if (has_pose_ && stamp > stamp_) velocity_ = velocity_to(stamp, pose);
    pose_ = pose;
    stamp_ = stamp;
    has_pose_ = true;
  }

  /// At rest, until there are two poses again.
  void restart(const SE3& pose) {
    pose_ = pose;
    velocity_.setZero();
    has_pose_ = false;
  }
  void slow_down(double share) { velocity_ *= share; }
  void move(const SE3& new_world_from_world) { pose_ = new_world_from_world * pose_; }

 private:
  bool has_pose_ = false;
  SE3 pose_;
  TimeNs stamp_ = 0;
  Vector6d velocity_ = Vector6d::Zero();
};

}  // namespace rastro
