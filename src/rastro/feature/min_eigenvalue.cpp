// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/min_eigenvalue.h"

#include <cmath>
#include <vector>

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int lanes = 16;  // Values of a row are computed in whole vectors; every buffer has room for it.

/// Sobel gradients of `count` pixels from above/here/below, whose [0] is the pixel left of the first one.
void gradient_row_plain(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int count,
                        std::int16_t* gx, std::int16_t* gy) {
  for (int i = 0; i < count; ++i) {
    const auto across = [i](const std::uint8_t* row) { return row[i] + 2 * row[i + 1] + row[i + 2]; };
    const auto down = [&](int k) { return above[i + k] + 2 * here[i + k] + below[i + k]; };
    gx[i] = static_cast<std::int16_t>(down(2) - down(0));
    gy[i] = static_cast<std::int16_t>(across(below) - across(above));
  }
}

/// Three rows of gradients around the output row.
struct GradientRows {
  const std::int16_t* x[3];
  const std::int16_t* y[3];
};

/// scores[i] from the gradients i, i+1, i+2 of three rows.
void score_row_plain(const GradientRows& rows, int count, float* scores) {
  for (int i = 0; i < count; ++i) {
    int xx = 0, xy = 0, yy = 0;
    for (int r = 0; r < 3; ++r) {
      for (int k = 0; k < 3; ++k) {
        const int gx = rows.x[r][i + k];
        const int gy = rows.y[r][i + k];
        xx += gx * gx;
        xy += gx * gy;
        yy += gy * gy;
      }
    }
    // Sums of nine products below 2^20 fit a float's 24 bits: no rounding before the square root.
    const float a = static_cast<float>(xx), b = static_cast<float>(xy), c = static_cast<float>(yy);
    const float difference = a - c;
    const float twice_b = b + b;
    scores[i] = (a + c) - std::sqrt(difference * difference + twice_b * twice_b);
  }
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 inline __m256i wide(const std::uint8_t* p) {
  return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
}

RASTRO_TARGET_AVX2 inline __m256i smoothed(__m256i a, __m256i b, __m256i c) {
  return _mm256_add_epi16(_mm256_add_epi16(a, c), _mm256_add_epi16(b, b));
}

RASTRO_TARGET_AVX2 void gradient_row_avx2(const std::uint8_t* above, const std::uint8_t* here,
                                          const std::uint8_t* below, int count, std::int16_t* gx, std::int16_t* gy) {
  for (int i = 0; i < count; i += lanes) {
    const __m256i above_left = wide(above + i), above_right = wide(above + i + 2);
    const __m256i below_left = wide(below + i), below_right = wide(below + i + 2);
    const __m256i left = smoothed(above_left, wide(here + i), below_left);
    const __m256i right = smoothed(above_right, wide(here + i + 2), below_right);
    const __m256i top = smoothed(above_left, wide(above + i + 1), above_right);
    const __m256i bottom = smoothed(below_left, wide(below + i + 1), below_right);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(gx + i), _mm256_sub_epi16(right, left));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(gy + i), _mm256_sub_epi16(bottom, top));
  }
}

/// Column sums over three rows of the products of 16 gradients: the values 0-3 and 8-11 in `low`, 4-7 and 12-15 in
/// `high`.
struct Products {
  __m256i low, high;
};

RASTRO_TARGET_AVX2 inline __m256i load16(const std::int16_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}

RASTRO_TARGET_AVX2 inline Products products(const __m256i* a, const __m256i* b) {
  const __m256i zero = _mm256_setzero_si256();
  const __m256i low =
      _mm256_add_epi32(_mm256_madd_epi16(_mm256_unpacklo_epi16(a[0], a[1]), _mm256_unpacklo_epi16(b[0], b[1])),
                       _mm256_madd_epi16(_mm256_unpacklo_epi16(a[2], zero), _mm256_unpacklo_epi16(b[2], zero)));
  const __m256i high =
      _mm256_add_epi32(_mm256_madd_epi16(_mm256_unpackhi_epi16(a[0], a[1]), _mm256_unpackhi_epi16(b[0], b[1])),
                       _mm256_madd_epi16(_mm256_unpackhi_epi16(a[2], zero), _mm256_unpackhi_epi16(b[2], zero)));
  return {low, high};
}

/// Stores the 16 sums in order.
RASTRO_TARGET_AVX2 inline void store(const Products& p, std::int32_t* out) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_permute2x128_si256(p.low, p.high, 0x20));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + 8), _mm256_permute2x128_si256(p.low, p.high, 0x31));
}

RASTRO_TARGET_AVX2 inline __m256 sum_of_three(const std::int32_t* columns) {
  const auto* const p = reinterpret_cast<const __m256i*>(columns);
  const auto* const q = reinterpret_cast<const __m256i*>(columns + 1);
  const auto* const r = reinterpret_cast<const __m256i*>(columns + 2);
  return _mm256_cvtepi32_ps(
      _mm256_add_epi32(_mm256_add_epi32(_mm256_loadu_si256(p), _mm256_loadu_si256(q)), _mm256_loadu_si256(r)));
}

RASTRO_TARGET_AVX2 void score_row_avx2(const GradientRows& rows, int count, float* scores, std::int32_t* columns,
                                       std::ptrdiff_t room) {
  std::int32_t *const xx = columns, *const xy = columns + room, *const yy = columns + 2 * room;
  for (int i = 0; i < count + 2; i += lanes) {
    const __m256i gx[3] = {load16(rows.x[0] + i), load16(rows.x[1] + i), load16(rows.x[2] + i)};
    const __m256i gy[3] = {load16(rows.y[0] + i), load16(rows.y[1] + i), load16(rows.y[2] + i)};
    store(products(gx, gx), xx + i);
    store(products(gx, gy), xy + i);
    store(products(gy, gy), yy + i);
  }
  for (int i = 0; i < count; i += 8) {
    const __m256 a = sum_of_three(xx + i), b = sum_of_three(xy + i), c = sum_of_three(yy + i);
    const __m256 difference = _mm256_sub_ps(a, c);
    const __m256 twice_b = _mm256_add_ps(b, b);
    const __m256 root =
        _mm256_sqrt_ps(_mm256_add_ps(_mm256_mul_ps(difference, difference), _mm256_mul_ps(twice_b, twice_b)));
    _mm256_storeu_ps(scores + i, _mm256_sub_ps(_mm256_add_ps(a, c), root));
  }
}
#endif

void compute_gradients(const PaddedImage& image, int x0, int count, int y0, int y1, MinEigenvalueScratch& scratch) {
  const int rows = y1 - y0;
  if (scratch.gradient_x.width() < count + 2 * lanes || scratch.gradient_x.height() < rows) {
    scratch.gradient_x = Image<std::int16_t>(count + 2 * lanes, rows);
    scratch.gradient_y = Image<std::int16_t>(count + 2 * lanes, rows);
  }
  for (int y = y0; y < y1; ++y) {
    const std::uint8_t* above = image.row(y - 1) + x0 - 1;
    const std::uint8_t* here = image.row(y) + x0 - 1;
    const std::uint8_t* below = image.row(y + 1) + x0 - 1;
    std::int16_t* gx = scratch.gradient_x.row(y - y0);
    std::int16_t* gy = scratch.gradient_y.row(y - y0);
#if RASTRO_HAS_AVX2_CODE
    if (simd_level() == SimdLevel::avx2) {
      gradient_row_avx2(above, here, below, count, gx, gy);
      continue;
    }
#endif
    gradient_row_plain(above, here, below, count, gx, gy);
  }
}

}  // namespace

void min_eigenvalues(const PaddedImage& image, int x0, int x1, int y0, int y1, float* scores, std::ptrdiff_t stride,
                     MinEigenvalueScratch& scratch) {
  RASTRO_CHECK(image.padding() >= min_eigenvalue_margin + lanes, "vectors read beyond the area");
  const int count = x1 - x0;
  compute_gradients(image, x0 - 1, count + 2, y0 - 1, y1 + 1, scratch);
#if RASTRO_HAS_AVX2_CODE
  const std::ptrdiff_t room = count + 3 * lanes;
  std::vector<std::int32_t> columns(static_cast<std::size_t>(3 * room));
#endif
  for (int y = y0; y < y1; ++y) {
    GradientRows rows{};
    for (int r = 0; r < 3; ++r) {
      rows.x[r] = scratch.gradient_x.row(y - y0 + r);
      rows.y[r] = scratch.gradient_y.row(y - y0 + r);
    }
#if RASTRO_HAS_AVX2_CODE
    if (simd_level() == SimdLevel::avx2) {
      score_row_avx2(rows, count, scores + (y - y0) * stride, columns.data(), room);
      continue;
    }
#endif
    score_row_plain(rows, count, scores + (y - y0) * stride);
  }
}

}  // namespace rastro
