// SPDX-License-Identifier: Apache-2.0
// Internal: included by files with AVX2 code only.
#pragma once

#include <immintrin.h>

#include <cstdint>

#include "rastro/base/simd.h"

#define RASTRO_EIGHT_LANES RASTRO_TARGET_AVX2 __attribute__((always_inline)) inline

// Eight pixels at a time: the twin of one_lane.h. Nothing here is fused, so that both round in the same way.
namespace rastro::eight_lanes {

constexpr int width = 8;

struct Mask {
  __m256 bits;
};
struct Integers {
  __m256i values;

  Integers() = default;
  RASTRO_TARGET_AVX2 __attribute__((always_inline)) explicit Integers(__m256i all) : values(all) {}
  RASTRO_TARGET_AVX2 __attribute__((always_inline)) Integers(int same) : values(_mm256_set1_epi32(same)) {}
};
struct Reals {
  __m256 values;

  Reals() = default;
  RASTRO_TARGET_AVX2 __attribute__((always_inline)) explicit Reals(__m256 all) : values(all) {}
  RASTRO_TARGET_AVX2 __attribute__((always_inline)) Reals(float same) : values(_mm256_set1_ps(same)) {}
};

RASTRO_EIGHT_LANES Reals operator+(Reals a, Reals b) { return Reals(_mm256_add_ps(a.values, b.values)); }
RASTRO_EIGHT_LANES Reals operator-(Reals a, Reals b) { return Reals(_mm256_sub_ps(a.values, b.values)); }
RASTRO_EIGHT_LANES Reals operator*(Reals a, Reals b) { return Reals(_mm256_mul_ps(a.values, b.values)); }
RASTRO_EIGHT_LANES Reals operator/(Reals a, Reals b) { return Reals(_mm256_div_ps(a.values, b.values)); }
RASTRO_EIGHT_LANES Mask operator<(Reals a, Reals b) { return {_mm256_cmp_ps(a.values, b.values, _CMP_LT_OQ)}; }
RASTRO_EIGHT_LANES Mask operator<=(Reals a, Reals b) { return {_mm256_cmp_ps(a.values, b.values, _CMP_LE_OQ)}; }
RASTRO_EIGHT_LANES Mask operator>(Reals a, Reals b) { return {_mm256_cmp_ps(a.values, b.values, _CMP_GT_OQ)}; }
RASTRO_EIGHT_LANES Mask operator>=(Reals a, Reals b) { return {_mm256_cmp_ps(a.values, b.values, _CMP_GE_OQ)}; }
RASTRO_EIGHT_LANES Mask operator&(Mask a, Mask b) { return {_mm256_and_ps(a.bits, b.bits)}; }
RASTRO_EIGHT_LANES Mask operator|(Mask a, Mask b) { return {_mm256_or_ps(a.bits, b.bits)}; }
RASTRO_EIGHT_LANES Mask operator!(Mask a) {
  return {_mm256_xor_ps(a.bits, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))};
}
RASTRO_EIGHT_LANES Integers operator+(Integers a, Integers b) { return Integers(_mm256_add_epi32(a.values, b.values)); }
RASTRO_EIGHT_LANES Integers operator*(Integers a, Integers b) {
  return Integers(_mm256_mullo_epi32(a.values, b.values));
}

RASTRO_EIGHT_LANES Reals load(const float* values) { return Reals(_mm256_loadu_ps(values)); }
RASTRO_EIGHT_LANES void store(Reals value, float* to) { _mm256_storeu_ps(to, value.values); }
RASTRO_EIGHT_LANES void store(Integers value, std::int32_t* to) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), value.values);
}
RASTRO_EIGHT_LANES Reals square_root(Reals value) { return Reals(_mm256_sqrt_ps(value.values)); }
RASTRO_EIGHT_LANES Reals absolute(Reals value) { return Reals(_mm256_andnot_ps(_mm256_set1_ps(-0.0F), value.values)); }
RASTRO_EIGHT_LANES Reals rounded_down(Reals value) { return Reals(_mm256_floor_ps(value.values)); }
/// The second one if either is not a number.
RASTRO_EIGHT_LANES Reals lesser(Reals a, Reals b) { return Reals(_mm256_min_ps(a.values, b.values)); }
RASTRO_EIGHT_LANES Reals greater(Reals a, Reals b) { return Reals(_mm256_max_ps(a.values, b.values)); }
RASTRO_EIGHT_LANES Integers truncated(Reals value) { return Integers(_mm256_cvttps_epi32(value.values)); }
RASTRO_EIGHT_LANES Reals real(Integers value) { return Reals(_mm256_cvtepi32_ps(value.values)); }
RASTRO_EIGHT_LANES Reals choose(Mask mask, Reals yes, Reals no) {
  return Reals(_mm256_blendv_ps(no.values, yes.values, mask.bits));
}
RASTRO_EIGHT_LANES Integers choose(Mask mask, Integers yes, Integers no) {
  return Integers(_mm256_castps_si256(
      _mm256_blendv_ps(_mm256_castsi256_ps(no.values), _mm256_castsi256_ps(yes.values), mask.bits)));
}
RASTRO_EIGHT_LANES Mask choose(Mask mask, Mask yes, Mask no) {
  return {_mm256_blendv_ps(no.bits, yes.bits, mask.bits)};
}
RASTRO_EIGHT_LANES bool any(Mask mask) { return _mm256_movemask_ps(mask.bits) != 0; }
RASTRO_EIGHT_LANES unsigned bits(Mask mask) { return static_cast<unsigned>(_mm256_movemask_ps(mask.bits)); }
RASTRO_EIGHT_LANES Reals every_second(const float* from) {
  const __m256 pairs = _mm256_shuffle_ps(_mm256_loadu_ps(from), _mm256_loadu_ps(from + 8), _MM_SHUFFLE(2, 0, 2, 0));
  return Reals(_mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(pairs), _MM_SHUFFLE(3, 1, 2, 0))));
}
RASTRO_EIGHT_LANES float largest(Reals value) {
  const __m128 four = _mm_max_ps(_mm256_castps256_ps128(value.values), _mm256_extractf128_ps(value.values, 1));
  const __m128 two = _mm_max_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)));
}

struct Neighbors {
  Reals first, second, third;
};
/// Reads four bytes at each offset.
RASTRO_EIGHT_LANES Neighbors neighbors_at(const std::uint8_t* base, Integers offset) {
  const __m256i words = _mm256_i32gather_epi32(reinterpret_cast<const int*>(base), offset.values, 1);
  const __m256i byte = _mm256_set1_epi32(0xFF);
  return {real(Integers(_mm256_and_si256(words, byte))),
          real(Integers(_mm256_and_si256(_mm256_srli_epi32(words, 8), byte))),
          real(Integers(_mm256_and_si256(_mm256_srli_epi32(words, 16), byte)))};
}

}  // namespace rastro::eight_lanes
