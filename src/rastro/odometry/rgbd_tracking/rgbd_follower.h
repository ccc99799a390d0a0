// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/math/se3.h"
#include "rastro/odometry/odometry.h"
#include "rastro/odometry/rgbd_tracking/options.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// What following one frame gave.
struct RgbdFollow {
  OdometryState state = OdometryState::initialising;
  OdometryReason reason = OdometryReason::none;
  std::string detail;     ///< The numbers behind the reason.
  SE3 world_from_camera;  ///< In the follower's world, which drifts. The guess by the last motion where lost.
  /// Of d in truth = world_from_camera * exp(d), (translation m, rotation rad), against the reference's local map.
  Matrix6d covariance = Matrix6d::Identity();
  SE3 world_from_reference;    ///< Pose of the newest reference frame, which the covariance counts from.
  bool new_reference = false;  ///< This frame became the newest reference.
  int points = 0;              ///< Features with a partner in the local map.
  int inliers = 0;             ///< Of these, explained by the pose.
  int surface_points = 0;      ///< Depth pixels that fit the reference's surfaces.
  double texture_share = 0.0;  ///< 0..1: how much of the pose rests on features, the rest on surfaces.
};

/// Follows a depth camera frame by frame against a local map of its last reference frames. The world is the first
/// frame's camera until moved. Results do not depend on the pool.
class RgbdFollower {
 public:
  /// `pool` may be null and must outlive this.
  RgbdFollower(const RgbdOptions& options, const Camera& camera, TaskPool* pool);
  ~RgbdFollower();
  /// Any frame is taken: an empty, black or repeated one gives a state that says so.
  RgbdFollow follow(const Frame& frame);
  /// Forgets the local map: the next frame is the first reference, at this pose. After a loss.
  void restart(const SE3& world_from_camera);
  /// Takes the world and everything in it elsewhere: the graph corrected the newest keyframe.
  void move(const SE3& new_world_from_world);
  /// Of the last frame, as followed or guessed.
  const SE3& world_from_camera() const;
  /// Where the reference frames stand now, oldest first.
  std::vector<SE3> reference_poses() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
