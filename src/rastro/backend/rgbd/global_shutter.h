// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/camera/camera.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// The frame as if all rows had been read at the instant of the middle one, while the camera only rotates (see
/// at_middle_row()): image, color, depth and mask. What would come from outside the image is masked, without depth.
/// `camera_rotation`: rad/s, in the camera's axes. The frame itself for a global shutter, without the size of the
/// camera, and where rows are off by less than is worth an interpolation.
Frame by_global_shutter(Frame frame, const Camera& camera, const Eigen::Vector3d& camera_rotation);

}  // namespace rastro
