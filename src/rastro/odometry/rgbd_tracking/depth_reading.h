// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"
#include "rastro/odometry/rgbd_tracking/options.h"

namespace rastro {

/// What the depth picture says along a ray of the colour camera.
struct DepthReading {
  double inverse_depth = 0.0;  ///< 1/m, along the colour camera's optical axis.
  double sigma = 0.0;          ///< Of it, 1/m.
  /// How it would change if the depth had been taken later than thought, 1/m/s. Filled by the follower.
  double per_second = 0.0;
};

/// Standard deviation of an inverse depth, 1/m: nearly the same everywhere, as disparity is what is measured.
double inverse_depth_sigma(const RgbdOptions& options, double inverse_depth);

/// Depth along `ray` (normalised) of the colour camera, from a plane through the 5x5 pixels around it. nullopt where
/// too little was measured, out of range, or at the edge of an object, where depth belongs to one side or the other.
/// `depth_from_colour`: motion from the colour picture's instant to the depth picture's.
std::optional<DepthReading> read_depth(const DepthImage& depth, const Camera& camera, const Eigen::Vector2d& ray,
                                       const SE3& depth_from_colour, const RgbdOptions& options);

}  // namespace rastro
