// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/camera/camera.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Factor by which a calibration corrects the depths of a camera that gives meters, at most: a larger one belongs to
/// readings in another unit, such as 5000 a meter in TUM's recordings.
constexpr double largest_depth_correction = 1.25;

/// A depth camera beside a color camera: what is needed to put its depth into the color image.
struct DepthRegistration {
  Camera depth_camera;   ///< With its size.
  SE3 color_from_depth;  ///< Point in the color camera from one in the depth camera, meters.
};

}  // namespace rastro
