// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/camera/camera.h"
#include "rastro/math/se3.h"

namespace rastro {

/// A depth camera beside a color camera: what is needed to put its depth into the color image.
struct DepthRegistration {
  Camera depth_camera;   ///< With its size.
  SE3 color_from_depth;  ///< Point in the color camera from one in the depth camera, meters.
};

}  // namespace rastro
