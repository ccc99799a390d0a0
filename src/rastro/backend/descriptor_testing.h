// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "rastro/base/random.h"
#include "rastro/feature/brief.h"

/// For tests only: descriptors with known distances.
namespace rastro::testing {

inline Descriptor random_descriptor(Random& random) {
  Descriptor descriptor;
  for (auto& word : descriptor.words) word = random.next();
  return descriptor;
}

/// A descriptor at Hamming distance `bits`, at most 256.
inline Descriptor flipped(Descriptor descriptor, int bits) {
  for (int k = 0; k < bits; ++k) descriptor.words[static_cast<std::size_t>(k % 4)] ^= std::uint64_t{1} << (k / 4);
  return descriptor;
}

}  // namespace rastro::testing
