// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/hamming.h"

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

void distances_plain(const Descriptor& query, const Descriptor* candidates, std::size_t count,
                     std::uint16_t* distances) {
  for (std::size_t i = 0; i < count; ++i)
    distances[i] = static_cast<std::uint16_t>(hamming_distance(query, candidates[i]));
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 void distances_popcnt(const Descriptor& query, const Descriptor* candidates, std::size_t count,
                                         std::uint16_t* distances) {
  const std::uint64_t q0 = query.words[0], q1 = query.words[1], q2 = query.words[2], q3 = query.words[3];
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t* words = candidates[i].words.data();
    distances[i] = static_cast<std::uint16_t>(_mm_popcnt_u64(q0 ^ words[0]) + _mm_popcnt_u64(q1 ^ words[1]) +
                                              _mm_popcnt_u64(q2 ^ words[2]) + _mm_popcnt_u64(q3 ^ words[3]));
  }
}
#endif

}  // namespace

void hamming_distances(const Descriptor& query, std::span<const Descriptor> candidates,
                       std::span<std::uint16_t> distances) {
  RASTRO_CHECK(distances.size() >= candidates.size(), "one element per distance");
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) {
    distances_popcnt(query, candidates.data(), candidates.size(), distances.data());
    return;
  }
#endif
  distances_plain(query, candidates.data(), candidates.size(), distances.data());
}

}  // namespace rastro
