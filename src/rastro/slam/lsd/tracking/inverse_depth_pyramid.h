// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/slam/lsd/inverse_depth_map.h"

namespace rastro {

/// Half the size, (w+1)/2 x (h+1)/2: pixel (x, y) lies at (2x, 2y) of `fine` and is the mean of the known ones of the 3
/// x 3 around it, with the binomial weights [1 2 1] divided by the variances (Engel et al. 2014, section 3.3). Errors
/// of neighboring pixels are correlated, so their number does not reduce the variance; a spread of the values, as at an
/// occlusion's edge, raises it.
InverseDepthMap halve(const InverseDepthMap& fine);
/// The same into a map that may be reused.
void halve(const InverseDepthMap& fine, InverseDepthMap& coarse);

/// Level 0 is a copy; pixel (x, y) of level l lies at (x, y) * 2^l of it, as in Pyramid.
std::vector<InverseDepthMap> inverse_depth_pyramid(const InverseDepthMap& map, int levels);

}  // namespace rastro
