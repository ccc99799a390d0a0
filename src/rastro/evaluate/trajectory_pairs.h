// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// Two poses of one instant, by their indices in the two trajectories.
struct PosePair {
  std::size_t reference = 0;
  std::size_t estimate = 0;
};

/// Associates poses whose stamps differ by at most `max_difference`: the pair with the smallest difference first, no
/// pose twice, and the pairs in the order of time on both sides. Both trajectories are in the order of time.
std::vector<PosePair> pair_by_stamp(const Trajectory& reference, const Trajectory& estimate, TimeNs max_difference);

/// Associates pose k with pose k, for files without stamps.
std::vector<PosePair> pair_by_index(const Trajectory& reference, const Trajectory& estimate);

/// Coverage: share (0..1) of the reference's poses that the estimate covers, i.e. within 0.6 of a step of a matched
/// pose. Step: the median step of the reference or of the estimate, whichever is longer, but the estimate's counts for
/// at most 0.1 s, so that a trajectory of keyframes does not count as complete. With `by_index` the step is one line.
double coverage_of(const Trajectory& reference, const Trajectory& estimate, const std::vector<PosePair>& pairs,
                   bool by_index);

}  // namespace rastro
