// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/registration/profiles/profile.h"

namespace rastro {

/// Shift between two profiles.
struct ProfileShift {
  double shift = 0.0;     ///< Steps that the content moved towards higher indices; sub-pixel.
  double residual = 0.0;  ///< p at the minimum: mean absolute residual, intensity levels.
  double at_zero = 0.0;   ///< p(0), intensity levels.
  double mean = 0.0;      ///< Mean of p over all shifts, intensity levels.
  /// 0..1: how much lower the minimum is than its best competitor, another local minimum or the mean. 0 for flat
  /// profiles and for a minimum at the end of the range.
  double confidence = 0.0;
  double sharpness = 0.0;  ///< Second difference of p at the minimum divided by the mean of p.
};

/// The shift d of METHODS 2.2: argmin over |d| <= max_shift of the mean absolute difference of current[n + d] and
/// previous[n] over the overlap, sub-pixel by a parabola through the minimum and its neighbors. Of equal minima the
/// one nearest to 0 wins. Profiles of one length; max_shift is limited to half of it. Without any overlap the
/// confidence is 0.
ProfileShift find_shift(const Profile& previous, const Profile& current, int max_shift);

/// Evaluates p(d), d = -max_shift .. max_shift, in intensity levels: minimum, parabola, confidence, sharpness.
ProfileShift lowest_of(const std::vector<double>& p);

/// Sum of the absolute differences of `count` values, each within 255 intensity levels of 0.
std::int64_t sum_of_differences(const std::int16_t* a, const std::int16_t* b, int count);

}  // namespace rastro
