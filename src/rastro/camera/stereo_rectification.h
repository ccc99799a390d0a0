// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/camera/undistort_map.h"
#include "rastro/math/se3.h"

namespace rastro {

/// Two cameras as one pair without distortion whose rows show the same (Fusiello, Trucco and Verri 2000, "A compact
/// algorithm for rectification of stereo pairs"): x along the baseline, looking between where both look.
struct StereoRectification {
  Camera camera;            ///< Of both pictures.
  double baseline = 0.0;    ///< Metres.
  SO3 left_from_rectified;  ///< Both rectified cameras are turned alike.
  UndistortMap left, right;
};

/// nullopt where the cameras do not say how large their pictures are, are not of one size, or are not side by side: the
/// right one more than 30 degrees off to the right of the left one, or the two looking more than 40 degrees apart.
std::optional<StereoRectification> rectify_stereo(const Camera& left, const Camera& right, const SE3& left_from_right);

}  // namespace rastro
