// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/camera/camera.h"

namespace rastro {

/// A pixel at the instant of the middle row.
struct PixelAtMiddleRow {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double depth_factor = 1.0;  ///< Of its depth along the optical axis, then by now.
};

/// Where a pixel would be, had the camera read all rows at the instant of the middle one, while it only rotates: what
/// translation shifts within a readout is small beside that (Forssen and Ringaby 2010, "Rectifying rolling shutter
/// video from hand-held devices", section 3). `angular_velocity`: rad/s, of the scene in the camera frame:
/// p(t + dt) = exp(angular_velocity dt) p(t). The pixel itself for a global shutter and outside the lens model.
PixelAtMiddleRow at_middle_row(const Camera& camera, const Eigen::Vector2d& pixel,
                               const Eigen::Vector3d& angular_velocity);

}  // namespace rastro
