// SPDX-License-Identifier: Apache-2.0
// Internal: included by files with AVX2 code only.
#pragma once

#include <immintrin.h>

#include "rastro/base/simd.h"

// Eight floats at once. Nothing here is fused, so that plain code rounds in the same way.
namespace rastro::lanes {

RASTRO_TARGET_AVX2 inline __m256 mul(__m256 a, __m256 b) { return _mm256_mul_ps(a, b); }
RASTRO_TARGET_AVX2 inline __m256 add(__m256 a, __m256 b) { return _mm256_add_ps(a, b); }
RASTRO_TARGET_AVX2 inline __m256 sub(__m256 a, __m256 b) { return _mm256_sub_ps(a, b); }
RASTRO_TARGET_AVX2 inline __m256 all(float value) { return _mm256_set1_ps(value); }

/// Two neighbors of an image row interpolated, from words whose lowest bytes they are.
RASTRO_TARGET_AVX2 inline __m256 between(__m256i words, __m256 fraction) {
  const __m256i byte = _mm256_set1_epi32(0xFF);
  const __m256 left = _mm256_cvtepi32_ps(_mm256_and_si256(words, byte));
  const __m256 right = _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(words, 8), byte));
  return add(left, mul(fraction, sub(right, left)));
}

}  // namespace rastro::lanes
