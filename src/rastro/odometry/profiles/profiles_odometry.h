// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/camera/camera.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/odometry/odometry.h"
#include "rastro/odometry/profiles/options.h"
#include "rastro/registration/profiles/rotation_chain.h"

namespace rastro {

/// Odometry from intensity profiles, METHODS 2.2: estimates the camera's rotation, not its translation. Each frame is
/// assumed to move `forward_step` ahead along the mean of its own and the previous frame's heading, so positions show
/// the path's shape at constant speed; a camera at rest is detected. Profiles after Milford and Wyeth 2008, "Mapping a
/// suburb with a single camera using a biologically inspired SLAM system".
///
/// Rejected frames are bridged with the last motion. The next usable frame is measured against the last usable one, so
/// no rotation between them is lost.
class ProfilesOdometry : public Odometry {
 public:
  /// Throws Error for settings out of range.
  ProfilesOdometry(const ProfilesOptions& options, const Camera& camera);

  OdometryUpdate process(const Frame& frame) override;
  Trajectory trajectory() const override { return trajectory_; }

 private:
  void bridge(OdometryUpdate& update);
  void follow(const RotationStep& step, OdometryUpdate& update);
  SE3 motion_of(const SO3& rotation, int frames) const;

  ProfilesOptions options_;
  FrameCheck check_;
  RotationChain rotations_;
  Trajectory trajectory_;
  bool has_reference_ = false;
  SE3 world_from_reference_;  ///< Of the last frame that was used.
  SE3 world_from_current_;
  int bridged_ = 0;  ///< Rejected frames since the last usable one.
};

}  // namespace rastro
