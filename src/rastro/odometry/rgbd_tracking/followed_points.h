// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/math/se3.h"
#include "rastro/odometry/rgbd_tracking/delayed_depth.h"
#include "rastro/odometry/rgbd_tracking/feature_tracker.h"
#include "rastro/odometry/rgbd_tracking/options.h"
#include "rastro/odometry/rgbd_tracking/point_map.h"
#include "rastro/odometry/rgbd_tracking/pose_solver.h"
#include "rastro/odometry/rgbd_tracking/rgbd_follower.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// The map's points in one frame: where they were found, and what is measured there.
class FollowedPoints {
 public:
  /// Both outlive this.
  FollowedPoints(const RgbdOptions& options, const Camera& camera) : options_(options), camera_(camera) {}

  /// `noise_factor`: of FeatureNoise.
  void take(std::vector<FoundPoint> found, const PointMap& map, double noise_factor);
  void clear();
  void read_depths(const Frame& frame, const Vector6d& velocity, const DelayedDepth& depth);
  /// Of each, whether it is within so many pixels of where a camera at `pose` (world_from_camera) sees it.
  std::vector<std::uint8_t> fitting(const SE3& pose, double within_px) const;
  /// Drops those that do not fit; in the map they are missed. Adds both kinds to `features`. Returns the share of the
  /// image with features that fits, 0..1.
  double keep_inliers(const SE3& pose, PointMap& map, std::vector<FollowedFeature>& features);
  /// The map's points get the depths read at this pose.
  void teach_depths(const SE3& pose, PointMap& map) const;

  const std::vector<FoundPoint>& found() const { return found_; }
  const std::vector<PointMeasurement>& measured() const { return measured_; }  ///< One by one as found().

 private:
  const RgbdOptions& options_;
  const Camera& camera_;
  std::vector<FoundPoint> found_;
  std::vector<PointMeasurement> measured_;
};

}  // namespace rastro
