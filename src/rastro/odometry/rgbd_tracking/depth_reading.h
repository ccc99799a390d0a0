// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"
#include "rastro/odometry/rgbd_tracking/options.h"

namespace rastro {

/// Depth measured along a ray of the color camera.
struct DepthReading {
  double inverse_depth = 0.0;  ///< 1/m, along the color camera's optical axis.
  double sigma = 0.0;          ///< Of it, 1/m.
  /// Its derivative by the delay of depth, 1/m/s. Filled by the follower.
  double per_second = 0.0;
};

/// Standard deviation of an inverse depth, 1/m. It is nearly constant, because the sensor measures disparity.
double inverse_depth_sigma(const RgbdOptions& options, double inverse_depth);

/// Depth along `ray` (normalized) of the color camera, from a plane through the 5x5 pixels around it. nullopt with too
/// few measurements, out of range, or at the edge of an object, where depth belongs to one side or the other.
/// `depth_from_color`: motion from the instant of the color image to that of the depth image. An edge is where the
/// pixels deviate from their plane by more than `depth_edge_sigmas` of one of them, rms; a small number also leaves out
/// the low steps between things that lie close to each other.
std::optional<DepthReading> read_depth(const DepthImage& depth, const Camera& camera, const Eigen::Vector2d& ray,
                                       const SE3& depth_from_color, const RgbdOptions& options);

}  // namespace rastro
