// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/slam/lsd/inverse_depth_map.h"

namespace rastro {

/// Mean squared distance of a pixel's inverse depth from its neighbors within six pixels that lie on another surface
/// (beyond two standard deviations); 0 where all lie on its own. Samples along a line show both surfaces, and what is
/// smoothed and carried to the next keyframe moves by some pixels more, so that the pixel may belong to either. The
/// pixel's depth is known.
float surface_spread(const InverseDepthMap& depth, int x, int y);

}  // namespace rastro
