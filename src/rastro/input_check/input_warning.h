// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace rastro {

/// Why an input cannot be what its calibration or its other sensors say.
struct InputWarning {
  /// "stamps_backward", "stereo_swapped", "stereo_unsynchronized", "stereo_not_rectified", "baseline", "depth_empty",
  /// "depth_constant", "depth_mirrored", "depth_late", "depth_scale", "focal_length", "laser_stuck", "laser_mirrored",
  /// "laser_scale", "laser_unit", "odometry_reversed", "odometry_stuck", "odometry_unit", "landmark_scale".
  std::string kind;
  std::string text;  ///< One line with the numbers and the likely cause.
};

using InputWarnings = std::vector<InputWarning>;

}  // namespace rastro
