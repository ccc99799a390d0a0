// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/math/se3.h"
#include "rastro/odometry/rgbd_tracking/depth_delay.h"
#include "rastro/odometry/rgbd_tracking/depth_reading.h"
#include "rastro/odometry/rgbd_tracking/options.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Depth along rays of a color image that was taken at another instant: by the stamps, and by a delay that they do not
/// show. The camera moves meanwhile, with `velocity` (m/s, rad/s, in its own axes).
class DelayedDepth {
 public:
  /// Both outlive this.
  DelayedDepth(const RgbdOptions& options, const Camera& camera) : options_(options), camera_(camera) {}

  /// `later_s`: as if the delay were longer.
  SE3 depth_from_color(const Frame& frame, const Vector6d& velocity, double later_s = 0.0) const;
  /// With its derivative by the delay, where that is learned.
  std::optional<DepthReading> read(const Frame& frame, const Eigen::Vector2d& ray, const Vector6d& velocity) const;
  /// As DepthDelay::learn().
  double learn(double information, double gradient) { return delay_.learn(information, gradient); }

 private:
  const RgbdOptions& options_;
  const Camera& camera_;
  DepthDelay delay_;
};

}  // namespace rastro
