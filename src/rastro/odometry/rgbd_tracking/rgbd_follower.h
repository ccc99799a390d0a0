// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
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

/// Result of tracking one frame.
struct RgbdFollow {
  OdometryState state = OdometryState::initializing;
  OdometryReason reason = OdometryReason::none;
  std::string detail;     ///< The numbers behind the reason.
  SE3 world_from_camera;  ///< In the follower's world, which drifts. Predicted where lost.
  /// Of d in true pose = world_from_camera * exp(d), (translation m, rotation rad), relative to the reference's local
  /// map.
  Matrix6d covariance = Matrix6d::Identity();
  SE3 world_from_reference;    ///< Pose of the newest reference frame, to which the covariance is relative.
  bool new_reference = false;  ///< This frame became the newest reference.
  int points = 0;              ///< Features matched with the local map.
  int inliers = 0;             ///< Of these, consistent with the pose.
  double inlier_share = 0.0;   ///< 0..1: of the image with features, the part that is consistent with the pose.
  int surface_points = 0;      ///< Depth pixels consistent with the reference's surfaces.
  double texture_share = 0.0;  ///< 0..1: how much of the pose rests on features, the rest on surfaces.
};

/// What became of a feature of the last frame.
struct FollowedFeature {
  enum class State : std::uint8_t {
    matched,  ///< Found again, but there is no pose to say whether rightly.
    inlier,
    outlier,  ///< Found again where the pose contradicts it.
    fresh,    ///< Taken into the local map with this frame.
  };
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  State state = State::matched;
};

/// Tracks a depth camera frame by frame against a local map of its last reference frames. The world is the first
/// frame's camera until it is moved. Results do not depend on the pool.
class RgbdFollower {
 public:
  /// `pool` may be null and must outlive this.
  RgbdFollower(const RgbdOptions& options, const Camera& camera, TaskPool* pool);
  ~RgbdFollower();
  /// Accepts any frame: an empty, black or repeated one gives a state that says so.
  RgbdFollow follow(const Frame& frame);
  /// Discards the local map after tracking was lost: the next frame with depth and a useful image, which may be the
  /// last one again, is the first reference, at this pose.
  void restart(const SE3& world_from_camera);
  /// Moves the world and everything in it, after the pose graph has corrected the newest keyframe.
  void move(const SE3& new_world_from_world);
  /// Pose of the last frame, estimated or predicted.
  const SE3& world_from_camera() const;
  /// Current poses of the reference frames, oldest first.
  std::vector<SE3> reference_poses() const;
  /// Of the last frame.
  const std::vector<FollowedFeature>& features() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
