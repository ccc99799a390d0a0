// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "rastro/slam/ekf/filter.h"
#include "rastro/slam/ekf/observation.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {

/// Whether drift makes it unsafe to associate an observation with this landmark by distance alone: its position
/// relative to the body is less certain than `unsure_m`, and that is not due to `noise_m2`, the trace of the covariance
/// of the observation or of those of before.
bool is_unsure(const EkfFilter::Expected& expected, double noise_m2, const EkfOptions& options);

/// A landmark of the last meters and the same one as it was mapped long before, by their numbers in the filter.
struct LandmarkPair {
  std::size_t recent, known;
};

/// Recognizes a mapped place after a long way: the largest set of pairs of recent and unsure landmarks that are jointly
/// compatible (J. Neira and J. D. Tardos, "Data association in stochastic mapping using the joint compatibility test",
/// 2001), at 99 %. Empty unless it has more than `companions` pairs, at least `lead` more than any other set, and takes
/// in most of the recent landmarks that are near mapped ones: places with the same furniture look alike. With it come
/// the pairs that are no longer doubtful once the set has corrected the drift: inside the gate, and no other nearly so.
std::vector<LandmarkPair> recognized_pairs(const EkfFilter& filter, std::span<const LandmarkRecord> records,
                                           const EkfOptions& options);

}  // namespace rastro
