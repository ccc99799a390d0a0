// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/box_sum.h"

#include <vector>

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int vector_tail = 32;

/// columns[i] += entering[i] - leaving[i]: the column sums one row further down.
void slide_columns_plain(const std::uint8_t* entering, const std::uint8_t* leaving, int count, std::uint16_t* columns) {
  for (int i = 0; i < count; ++i) columns[i] = static_cast<std::uint16_t>(columns[i] + entering[i] - leaving[i]);
}

void sum_across_plain(const std::uint16_t* columns, int taps, int width, std::uint16_t* out) {
  unsigned sum = 0;
  for (int i = 0; i < taps - 1; ++i) sum += columns[i];
  for (int x = 0; x < width; ++x) {
    sum += columns[x + taps - 1];
    out[x] = static_cast<std::uint16_t>(sum);
    sum -= columns[x];
  }
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 void slide_columns_avx2(const std::uint8_t* entering, const std::uint8_t* leaving, int count,
                                           std::uint16_t* columns) {
  int i = 0;
  for (; i + 16 <= count; i += 16) {
    const __m256i in = _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(entering + i)));
    const __m256i out = _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(leaving + i)));
    auto* const at = reinterpret_cast<__m256i*>(columns + i);
    _mm256_storeu_si256(at, _mm256_add_epi16(_mm256_loadu_si256(at), _mm256_sub_epi16(in, out)));
  }
  slide_columns_plain(entering + i, leaving + i, count - i, columns + i);
}

RASTRO_TARGET_AVX2 void sum_across_avx2(const std::uint16_t* columns, int taps, int width, std::uint16_t* out) {
  int x = 0;
  for (; x + 16 <= width; x += 16) {
    __m256i sum = _mm256_setzero_si256();
    for (int tap = 0; tap < taps; ++tap) {
      sum = _mm256_add_epi16(sum, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(columns + x + tap)));
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + x), sum);
  }
  sum_across_plain(columns + x, taps, width - x, out + x);
}
#endif

}  // namespace

void box_sums(const PaddedImage& image, int radius, Image<std::uint16_t>& sums) {
  RASTRO_CHECK(radius >= 0 && radius <= 7 && image.padding() > radius, "a box sum fits 16 bits and the padding");
  if (sums.width() != image.width() || sums.height() != image.height()) {
    sums = Image<std::uint16_t>(image.width(), image.height());
  }
  const int count = image.width() + 2 * radius;
  std::vector<std::uint16_t> columns(static_cast<std::size_t>(count + vector_tail));
  for (int r = -radius - 1; r < radius; ++r) {
    for (int i = 0; i < count; ++i) columns[static_cast<std::size_t>(i)] += image.row(r)[i - radius];
  }
  for (int y = 0; y < image.height(); ++y) {
    const std::uint8_t* entering = image.row(y + radius) - radius;
    const std::uint8_t* leaving = image.row(y - radius - 1) - radius;
#if RASTRO_HAS_AVX2_CODE
    if (simd_level() == SimdLevel::avx2) {
      slide_columns_avx2(entering, leaving, count, columns.data());
      sum_across_avx2(columns.data(), 2 * radius + 1, image.width(), sums.row(y));
      continue;
    }
#endif
    slide_columns_plain(entering, leaving, count, columns.data());
    sum_across_plain(columns.data(), 2 * radius + 1, image.width(), sums.row(y));
  }
}

}  // namespace rastro
