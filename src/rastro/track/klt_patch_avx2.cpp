// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/simd.h"
#include "rastro/track/klt_patch.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {

#if RASTRO_HAS_AVX2_CODE
namespace {

constexpr int row_length = KltPatch::row_length;

RASTRO_TARGET_AVX2 inline __m256i load(const std::int16_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
RASTRO_TARGET_AVX2 inline void store(std::int16_t* p, __m256i v) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), v);
}

/// 16 pixels of a row in 1/32 level, interpolated horizontally.
RASTRO_TARGET_AVX2 inline __m256i across(const std::uint8_t* pixels, __m256i fraction) {
  const __m256i left = _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(pixels)));
  const __m256i right = _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(pixels + 1)));
  const __m256i step = _mm256_slli_epi16(_mm256_sub_epi16(right, left), 5);
  return _mm256_add_epi16(_mm256_slli_epi16(left, 5), _mm256_mulhrs_epi16(step, fraction));
}

RASTRO_TARGET_AVX2 inline __m256i between(__m256i above, __m256i below, __m256i fraction) {
  return _mm256_add_epi16(above, _mm256_mulhrs_epi16(_mm256_sub_epi16(below, above), fraction));
}

/// Adds the eight 32-bit lanes in 64 bits.
RASTRO_TARGET_AVX2 inline std::int64_t sum(__m256i lanes) {
  const __m256i low = _mm256_cvtepi32_epi64(_mm256_castsi256_si128(lanes));
  const __m256i high = _mm256_cvtepi32_epi64(_mm256_extracti128_si256(lanes, 1));
  const __m256i four = _mm256_add_epi64(low, high);
  const __m128i two = _mm_add_epi64(_mm256_castsi256_si128(four), _mm256_extracti128_si256(four, 1));
  return _mm_cvtsi128_si64(two) + _mm_extract_epi64(two, 1);
}

/// (a + 2b + c + 2) >> 2
RASTRO_TARGET_AVX2 inline __m256i smoothed(__m256i a, __m256i b, __m256i c) {
  const __m256i total = _mm256_add_epi16(_mm256_add_epi16(a, c), _mm256_add_epi16(b, b));
  return _mm256_srai_epi16(_mm256_add_epi16(total, _mm256_set1_epi16(2)), 2);
}

/// Interpolates (size + 2) rows of 48 columns, one pixel more on each side than the window.
RASTRO_TARGET_AVX2 void interpolate_wide(const KltWindow& window, int size, std::int16_t (*wide)[48]) {
  const __m256i fraction_x = _mm256_set1_epi16(window.fraction_x);
  const __m256i fraction_y = _mm256_set1_epi16(window.fraction_y);
  const int vectors = (size + 2 + 15) / 16;
  for (int v = 0; v < vectors; ++v) {
    __m256i above = across(window.row(-1) - 1 + 16 * v, fraction_x);
    for (int y = 0; y < size + 2; ++y) {
      const __m256i below = across(window.row(y) - 1 + 16 * v, fraction_x);
      store(wide[y] + 16 * v, between(above, below, fraction_y));
      above = below;
    }
  }
}

RASTRO_TARGET_AVX2 void cut_avx2(const KltWindow& window, int size, KltPatch& patch) {
  alignas(32) std::int16_t wide[KltPatch::most_rows + 2][48];
  interpolate_wide(window, size, wide);
  patch.size = size;
  for (int x = 0; x < row_length; ++x) patch.ones[x] = x < size ? 1 : 0;
  const __m256i one = _mm256_set1_epi16(1);
  __m256i xx = _mm256_setzero_si256(), xy = xx, yy = xx, sum_x = xx, sum_y = xx;
  for (int v = 0; v < 2; ++v) {
    const __m256i inside = _mm256_cmpeq_epi16(load(patch.ones + 16 * v), one);
    for (int y = 0; y < size; ++y) {
      const int at = y * row_length + 16 * v;
      if (16 * v >= size) {
        store(patch.intensity + at, _mm256_setzero_si256());
        store(patch.gradient_x + at, _mm256_setzero_si256());
        store(patch.gradient_y + at, _mm256_setzero_si256());
        continue;
      }
      const std::int16_t *above = wide[y] + 16 * v, *here = wide[y + 1] + 16 * v, *below = wide[y + 2] + 16 * v;
      const __m256i above_left = load(above), above_right = load(above + 2);
      const __m256i below_left = load(below), below_right = load(below + 2);
      const __m256i left = smoothed(above_left, load(here), below_left);
      const __m256i right = smoothed(above_right, load(here + 2), below_right);
      const __m256i top = smoothed(above_left, load(above + 1), above_right);
      const __m256i bottom = smoothed(below_left, load(below + 1), below_right);
      const __m256i gx = _mm256_and_si256(_mm256_srai_epi16(_mm256_sub_epi16(right, left), 2), inside);
      const __m256i gy = _mm256_and_si256(_mm256_srai_epi16(_mm256_sub_epi16(bottom, top), 2), inside);
      store(patch.intensity + at, _mm256_and_si256(load(here + 1), inside));
      store(patch.gradient_x + at, gx);
      store(patch.gradient_y + at, gy);
      xx = _mm256_add_epi32(xx, _mm256_madd_epi16(gx, gx));
      xy = _mm256_add_epi32(xy, _mm256_madd_epi16(gx, gy));
      yy = _mm256_add_epi32(yy, _mm256_madd_epi16(gy, gy));
      sum_x = _mm256_add_epi32(sum_x, _mm256_madd_epi16(gx, one));
      sum_y = _mm256_add_epi32(sum_y, _mm256_madd_epi16(gy, one));
    }
  }
  patch.xx = sum(xx);
  patch.xy = sum(xy);
  patch.yy = sum(yy);
  patch.x = sum(sum_x);
  patch.y = sum(sum_y);
}

// A lane adds at most 2 * 31 products below 2^13 * 2^11 in each half of the row: below 2^31, no overflow.
RASTRO_TARGET_AVX2 KltMismatch mismatch_avx2(const KltWindow& window, const KltPatch& patch) {
  const __m256i fraction_x = _mm256_set1_epi16(window.fraction_x);
  const __m256i fraction_y = _mm256_set1_epi16(window.fraction_y);
  KltMismatch sums;
  for (int v = 0; 16 * v < patch.size; ++v) {
    const __m256i ones = load(patch.ones + 16 * v);
    __m256i ex = _mm256_setzero_si256(), ey = ex, e = ex;
    const std::uint8_t* pixels = window.row(0) + 16 * v;
    const std::ptrdiff_t stride = window.stride;
    __m256i above = across(pixels, fraction_x);
    for (int y = 0; y < patch.size; ++y) {
      pixels += stride;
      const int at = y * row_length + 16 * v;
      const __m256i below = across(pixels, fraction_x);
      const __m256i difference = _mm256_sub_epi16(between(above, below, fraction_y), load(patch.intensity + at));
      ex = _mm256_add_epi32(ex, _mm256_madd_epi16(difference, load(patch.gradient_x + at)));
      ey = _mm256_add_epi32(ey, _mm256_madd_epi16(difference, load(patch.gradient_y + at)));
      e = _mm256_add_epi32(e, _mm256_madd_epi16(difference, ones));
      above = below;
    }
    sums.ex += sum(ex);
    sums.ey += sum(ey);
    sums.e += sum(e);
  }
  return sums;
}

RASTRO_TARGET_AVX2 KltResidual residual_avx2(const KltWindow& window, const KltPatch& patch) {
  const __m256i fraction_x = _mm256_set1_epi16(window.fraction_x);
  const __m256i fraction_y = _mm256_set1_epi16(window.fraction_y);
  KltResidual sums;
  for (int v = 0; 16 * v < patch.size; ++v) {
    const __m256i ones = load(patch.ones + 16 * v);
    const __m256i inside = _mm256_cmpeq_epi16(ones, _mm256_set1_epi16(1));
    __m256i squared_difference = _mm256_setzero_si256(), difference_sum = squared_difference;
    __m256i squared_patch = squared_difference, patch_sum = squared_difference;
    __m256i above = across(window.row(0) + 16 * v, fraction_x);
    for (int y = 0; y < patch.size; ++y) {
      const __m256i below = across(window.row(y + 1) + 16 * v, fraction_x);
      const __m256i intensity = load(patch.intensity + y * row_length + 16 * v);
      const __m256i raw = _mm256_sub_epi16(between(above, below, fraction_y), intensity);
      const __m256i difference = _mm256_and_si256(_mm256_srai_epi16(raw, 2), inside);
      const __m256i value = _mm256_srai_epi16(intensity, 2);
      squared_difference = _mm256_add_epi32(squared_difference, _mm256_madd_epi16(difference, difference));
      difference_sum = _mm256_add_epi32(difference_sum, _mm256_madd_epi16(difference, ones));
      squared_patch = _mm256_add_epi32(squared_patch, _mm256_madd_epi16(value, value));
      patch_sum = _mm256_add_epi32(patch_sum, _mm256_madd_epi16(value, ones));
      above = below;
    }
    sums.squared_difference += sum(squared_difference);
    sums.difference += sum(difference_sum);
    sums.squared_patch += sum(squared_patch);
    sums.patch += sum(patch_sum);
  }
  return sums;
}

/// Eight pairs of neighboring pixels, interpolated horizontally, in 1/256 level.
RASTRO_TARGET_AVX2 inline __m256i gathered(const std::uint8_t* pixels, __m256i offsets, __m256i weights) {
  const __m256i four = _mm256_i32gather_epi32(reinterpret_cast<const int*>(pixels), offsets, 1);
  const __m256i left = _mm256_and_si256(four, _mm256_set1_epi32(0xff));
  const __m256i right = _mm256_and_si256(_mm256_slli_epi32(four, 8), _mm256_set1_epi32(0xff0000));
  return _mm256_madd_epi16(_mm256_or_si256(left, right), weights);
}

RASTRO_TARGET_AVX2 void rotate_avx2(const KltRotation& rotation, std::uint8_t* rotated) {
  const __m256i most = _mm256_set1_epi32((rotation.side - 1) * 65536 - 1), zero = _mm256_setzero_si256();
  const __m256i side = _mm256_set1_epi32(rotation.side), one = _mm256_set1_epi32(256), byte = _mm256_set1_epi32(255);
  const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i lanes_x = _mm256_mullo_epi32(lanes, _mm256_set1_epi32(rotation.across_x));
  const __m256i lanes_y = _mm256_mullo_epi32(lanes, _mm256_set1_epi32(rotation.across_y));
  for (int y = 0; y < rotation.rows; ++y) {
    std::uint8_t* out = rotated + y * KltRotation::row_length;
    for (int x = 0; x < rotation.rows; x += 8) {
      const __m256i at_x =
          _mm256_add_epi32(_mm256_set1_epi32(rotation.x + y * rotation.down_x + x * rotation.across_x), lanes_x);
      const __m256i at_y =
          _mm256_add_epi32(_mm256_set1_epi32(rotation.y + y * rotation.down_y + x * rotation.across_y), lanes_y);
      const __m256i px = _mm256_min_epi32(_mm256_max_epi32(at_x, zero), most);
      const __m256i py = _mm256_min_epi32(_mm256_max_epi32(at_y, zero), most);
      const __m256i offsets =
          _mm256_add_epi32(_mm256_mullo_epi32(_mm256_srai_epi32(py, 16), side), _mm256_srai_epi32(px, 16));
      const __m256i fx = _mm256_and_si256(_mm256_srai_epi32(px, 8), byte);
      const __m256i fy = _mm256_and_si256(_mm256_srai_epi32(py, 8), byte);
      const __m256i weights = _mm256_or_si256(_mm256_sub_epi32(one, fx), _mm256_slli_epi32(fx, 16));
      const __m256i upper = gathered(rotation.pixels, offsets, weights);
      const __m256i lower = gathered(rotation.pixels + rotation.side, offsets, weights);
      const __m256i both =
          _mm256_add_epi32(_mm256_mullo_epi32(upper, _mm256_sub_epi32(one, fy)), _mm256_mullo_epi32(lower, fy));
      const __m256i gray = _mm256_srli_epi32(_mm256_add_epi32(both, _mm256_set1_epi32(32768)), 16);
      const __m128i words = _mm_packus_epi32(_mm256_castsi256_si128(gray), _mm256_extracti128_si256(gray, 1));
      _mm_storel_epi64(reinterpret_cast<__m128i*>(out + x), _mm_packus_epi16(words, words));
    }
  }
}

}  // namespace

const KltKernels& klt_kernels_avx2() {
  static const KltKernels kernels{cut_avx2, mismatch_avx2, residual_avx2, rotate_avx2};
  return kernels;
}
#else
const KltKernels& klt_kernels_avx2() { return klt_kernels_plain(); }
#endif

}  // namespace rastro
