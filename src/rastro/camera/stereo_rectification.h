// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/camera/undistort_map.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Rectification of two cameras: an undistorted pair with horizontal epipolar lines (Fusiello, Trucco and Verri 2000,
/// "A compact algorithm for rectification of stereo pairs"). x points along the baseline, z between the two original
/// viewing directions.
struct StereoRectification {
  Camera camera;            ///< Of both images.
  double baseline = 0.0;    ///< Meters.
  SO3 left_from_rectified;  ///< Both rectified cameras have the same orientation.
  UndistortMap left, right;
};

/// nullopt if the cameras have no image size, differ in size, or are not side by side: the right one more than 30
/// degrees off the direction to the right of the left one, or viewing directions more than 40 degrees apart.
std::optional<StereoRectification> rectify_stereo(const Camera& left, const Camera& right, const SE3& left_from_right);

}  // namespace rastro
