// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// The motions second_from_first with which a plane in view gives this homography between normalised points
/// (second ~ homography * first, of a sign that keeps points in front): four, with translations of length 1, or one
/// without translation where the homography is a rotation. Which of them holds, the points say. Ma et al. 2004, "An
/// invitation to 3-D vision", section 5.3.3. Empty for a singular matrix.
std::vector<SE3> motions_of_homography(const Eigen::Matrix3d& homography);

}  // namespace rastro
