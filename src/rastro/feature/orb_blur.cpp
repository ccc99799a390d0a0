// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/orb_blur.h"

#include <array>
#include <vector>

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int radius = 3;
constexpr int lanes = 16;
/// exp(-d^2 / 8) for d = 0..3, scaled so that all seven sum to 64 and 256.
constexpr int down[4] = {14, 12, 8, 5};
constexpr int across[4] = {54, 49, 34, 18};
static_assert(down[0] + 2 * (down[1] + down[2] + down[3]) == 64);
static_assert(across[0] + 2 * (across[1] + across[2] + across[3]) == 256);

using Rows = std::array<const std::uint8_t*, 7>;

void blur_down_plain(const Rows& rows, int count, std::int16_t* columns) {
  for (int i = 0; i < count; ++i) {
    int sum = down[0] * rows[radius][i];
    for (std::size_t d = 1; d <= radius; ++d) sum += down[d] * (rows[radius - d][i] + rows[radius + d][i]);
    columns[i] = static_cast<std::int16_t>(sum);
  }
}

/// columns[0] is three left of the first pixel.
void blur_across_plain(const std::int16_t* columns, int width, std::uint8_t* out) {
  for (int x = 0; x < width; ++x) {
    const std::int16_t* c = columns + x + radius;
    int sum = across[0] * c[0];
    for (int d = 1; d <= radius; ++d) sum += across[d] * (c[-d] + c[d]);
    out[x] = static_cast<std::uint8_t>((sum + 8192) >> 14);
  }
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 inline __m256i wide(const std::uint8_t* p) {
  return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
}

RASTRO_TARGET_AVX2 void blur_down_avx2(const Rows& rows, int count, std::int16_t* columns) {
  for (int i = 0; i < count; i += lanes) {
    __m256i sum = _mm256_mullo_epi16(wide(rows[3] + i), _mm256_set1_epi16(down[0]));
    for (std::size_t d = 1; d <= radius; ++d) {
      const __m256i both = _mm256_add_epi16(wide(rows[3 - d] + i), wide(rows[3 + d] + i));
      sum = _mm256_add_epi16(sum, _mm256_mullo_epi16(both, _mm256_set1_epi16(static_cast<short>(down[d]))));
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(columns + i), sum);
  }
}

RASTRO_TARGET_AVX2 inline __m256i column(const std::int16_t* c) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(c));
}

/// 16 pixels, as words in the order of the two halves' unpacking.
RASTRO_TARGET_AVX2 inline __m256i blurred_across(const std::int16_t* c) {
  const __m256i middle = column(c + 3);
  const __m256i one = _mm256_add_epi16(column(c + 2), column(c + 4));
  const __m256i two = _mm256_add_epi16(column(c + 1), column(c + 5));
  const __m256i three = _mm256_add_epi16(column(c), column(c + 6));
  const __m256i inner = _mm256_set1_epi32(across[1] << 16 | across[0]);
  const __m256i outer = _mm256_set1_epi32(across[3] << 16 | across[2]);
  const __m256i half = _mm256_set1_epi32(8192);
  __m256i low = _mm256_add_epi32(_mm256_madd_epi16(_mm256_unpacklo_epi16(middle, one), inner),
                                 _mm256_madd_epi16(_mm256_unpacklo_epi16(two, three), outer));
  __m256i high = _mm256_add_epi32(_mm256_madd_epi16(_mm256_unpackhi_epi16(middle, one), inner),
                                  _mm256_madd_epi16(_mm256_unpackhi_epi16(two, three), outer));
  low = _mm256_srli_epi32(_mm256_add_epi32(low, half), 14);
  high = _mm256_srli_epi32(_mm256_add_epi32(high, half), 14);
  return _mm256_packus_epi32(low, high);
}

RASTRO_TARGET_AVX2 void blur_across_avx2(const std::int16_t* columns, int width, std::uint8_t* out) {
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const __m256i words = blurred_across(columns + x);
    const __m128i bytes = _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + x), bytes);
  }
  blur_across_plain(columns + x, width - x, out + x);
}
#endif

}  // namespace

void orb_blur(const PaddedImage& source, GrayImage& target, int begin, int end) {
  RASTRO_CHECK(source.padding() >= radius + 2 * lanes && source.width() == target.width(),
               "the blur reads outside the image");
  const int count = source.width() + 2 * radius;
  std::vector<std::int16_t> columns(static_cast<std::size_t>(count) + 2 * lanes);
  for (int y = begin; y < end; ++y) {
    Rows rows{};
    for (int r = 0; r < 7; ++r) rows[static_cast<std::size_t>(r)] = source.row(y + r - radius) - radius;
#if RASTRO_HAS_AVX2_CODE
    if (simd_level() == SimdLevel::avx2) {
      blur_down_avx2(rows, count, columns.data());
      blur_across_avx2(columns.data(), source.width(), target.row(y));
      continue;
    }
#endif
    blur_down_plain(rows, count, columns.data());
    blur_across_plain(columns.data(), source.width(), target.row(y));
  }
}

}  // namespace rastro
