// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "rastro/feature/brief.h"

namespace rastro {

/// distances[i] = hamming_distance(query, candidates[i]), by the widest popcount the processor has.
void hamming_distances(const Descriptor& query, std::span<const Descriptor> candidates,
                       std::span<std::uint16_t> distances);

}  // namespace rastro
