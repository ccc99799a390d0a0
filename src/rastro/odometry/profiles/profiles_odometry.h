// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/camera/camera.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/odometry/odometry.h"
#include "rastro/odometry/profiles/options.h"
#include "rastro/registration/profiles/rotation_chain.h"

namespace rastro {

/// Odometry from intensity profiles, METHODS 2.2: it knows how the camera turns, not how it moves. Each frame is taken
/// to go `forward_step` ahead along the mean of its and the last frame's heading, so that positions show the path's
/// shape at constant speed; standing still is noticed. Milford and Wyeth 2008, "Mapping a suburb with a single camera
/// using a biologically inspired SLAM system", is where such profiles come from.
///
/// Frames without use are bridged with the last motion, and the next useful one is measured against the last useful
/// one, so that nothing of the turn between them is lost.
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
  SE3 world_from_reference_;  ///< Of the last frame that was used.
  SE3 world_from_current_;
  int bridged_ = 0;  ///< Frames without use since the last useful one.
};

}  // namespace rastro
