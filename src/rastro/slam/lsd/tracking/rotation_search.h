// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/pyramid.h"
#include "rastro/math/so3.h"
#include "rastro/slam/lsd/tracking/alignment_reference.h"

namespace rastro {

struct RotationGuess {
  SO3 b_from_a;
  double correlation = -1.0;  ///< Of the intensities where both images overlap, -1 to 1.
};

/// Rotation between two images by the shift of a small one that correlates best (Klein and Murray 2008, "Improving the
/// agility of keyframe-based SLAM", without the rotation about the optical axis): all shifts of up to half of the image
/// are tried, so that it needs no guess. Certain to about a pixel of the small image.
RotationGuess find_rotation(GrayView a, GrayView b, const LevelCamera& camera);

}  // namespace rastro
