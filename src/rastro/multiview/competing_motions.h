// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// The other motions that explain the pairs: local minima of the squared Sampson distances whose translation differs in
/// direction by `least_angle_deg` or more from that of `found`, with either sign. The error has several minima where
/// the field of view is narrow, the parallax small or the scene nearly flat, and noise may make a wrong one the least
/// (Maybank 1993; Chiuso et al. 2000, "Optimal structure from motion: local ambiguities and global estimates").
/// `a`, `b`: normalized points of the first and second view, of which those with is_inlier are used. Refined from
/// translations all around; the same minimum may come more than once.
std::vector<SE3> competing_motions(const SE3& found, std::span<const Eigen::Vector2d> a,
                                   std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier,
                                   double least_angle_deg);

}  // namespace rastro
