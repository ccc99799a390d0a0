// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// Decomposition of a homography: the motions second_from_first with which a visible plane gives this homography
/// between normalized points (second ~ homography * first, with the sign that keeps points in front). Four, with
/// translations of length 1, or one without translation if the homography is a rotation; the points decide between
/// them. Ma et al. 2004, "An invitation to 3-D vision", section 5.3.3. Empty for a singular matrix.
std::vector<SE3> motions_of_homography(const Eigen::Matrix3d& homography);

}  // namespace rastro
