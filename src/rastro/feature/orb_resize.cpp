// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/orb_resize.h"

#include <algorithm>
#include <cmath>

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int steps =
    64;  // Fraction bits of a horizontal weight; the sum of both still fits a signed byte's product with a pixel.
constexpr int block = 8;

double source_of(int pixel, double factor) { return (pixel + 0.5) * factor - 0.5; }

/// What _mm256_mulhrs_epi16 does.
int rounded_product(int a, int b) { return (a * b + 0x4000) >> 15; }

void blend_rows_plain(const std::int16_t* above, const std::int16_t* below, int weight, int width, std::uint8_t* out) {
  for (int x = 0; x < width; ++x)
    out[x] = static_cast<std::uint8_t>((above[x] + rounded_product(below[x] - above[x], weight) + steps / 2) / steps);
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 inline __m256i blended(const std::int16_t* above, const std::int16_t* below, __m256i weight) {
  const __m256i a = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(above));
  const __m256i b = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(below));
  const __m256i sum = _mm256_add_epi16(a, _mm256_mulhrs_epi16(_mm256_sub_epi16(b, a), weight));
  return _mm256_srli_epi16(_mm256_add_epi16(sum, _mm256_set1_epi16(steps / 2)), 6);
}

/// Writes whole vectors; the row's padding takes the rest.
RASTRO_TARGET_AVX2 void blend_rows_avx2(const std::int16_t* above, const std::int16_t* below, std::int16_t weight,
                                        int width, std::uint8_t* out) {
  const __m256i weights = _mm256_set1_epi16(weight);
  for (int x = 0; x < width; x += 32) {
    const __m256i low = blended(above + x, below + x, weights);
    const __m256i high = blended(above + x + 16, below + x + 16, weights);
    const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi16(low, high), 0b11011000);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + x), packed);
  }
}
#endif

void blend_rows(const std::int16_t* above, const std::int16_t* below, std::int16_t weight, int width,
                std::uint8_t* out) {
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) {
    blend_rows_avx2(above, below, weight, width, out);
    return;
  }
#endif
  blend_rows_plain(above, below, weight, width, out);
}

}  // namespace

OrbResize::OrbResize(int source_width, int source_height, double factor)
    : width_(static_cast<int>(std::lround(source_width / factor))),
      height_(static_cast<int>(std::lround(source_height / factor))) {
  RASTRO_CHECK(factor >= 1.0 && factor <= 2.0, "eight pixels come from sixteen");
  for (int x = 0; x < width_; x += block) {
    Block& made = blocks_.emplace_back();
    made.start = static_cast<int>(std::floor(source_of(x, factor)));
    for (int i = 0; i < block; ++i) {
      const int at = static_cast<int>(std::lround((source_of(x + i, factor) - made.start) * steps));
      // By a factor near two the last of eight can end in the seventeenth byte.
      const int left = std::min(at / steps, 14), weight = std::min(at - left * steps, steps);
      const auto index = static_cast<std::size_t>(2 * i);
      made.bytes[index] = static_cast<std::uint8_t>(left);
      made.bytes[index + 1] = static_cast<std::uint8_t>(left + 1);
      made.weights[index] = static_cast<std::int8_t>(steps - weight);
      made.weights[index + 1] = static_cast<std::int8_t>(weight);
    }
  }
  for (int y = 0; y < height_; ++y) {
    const double at = source_of(y, factor);
    const int above = static_cast<int>(std::floor(at));
    rows_.push_back({above, static_cast<std::int16_t>(std::min(32767L, std::lround((at - above) * 32768.0)))});
  }
}

void OrbResize::shrink_row(const std::uint8_t* source, std::int16_t* out) const {
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) {
    shrink_row_avx2(source, out);
    return;
  }
#endif
  for (const Block& made : blocks_) {
    for (std::size_t i = 0; i < 2 * block; i += 2) {
      const int left = source[made.start + made.bytes[i]], right = source[made.start + made.bytes[i + 1]];
      *out++ = static_cast<std::int16_t>(left * made.weights[i] + right * made.weights[i + 1]);
    }
  }
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 void OrbResize::shrink_row_avx2(const std::uint8_t* source, std::int16_t* out) const {
  for (const Block& made : blocks_) {
    const __m128i pixels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(source + made.start));
    const __m128i pairs = _mm_shuffle_epi8(pixels, _mm_loadu_si128(reinterpret_cast<const __m128i*>(&made.bytes)));
    const __m128i weights = _mm_loadu_si128(reinterpret_cast<const __m128i*>(&made.weights));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm_maddubs_epi16(pairs, weights));
    out += block;
  }
}
#else
void OrbResize::shrink_row_avx2(const std::uint8_t*, std::int16_t*) const {}
#endif

void OrbResize::run(const PaddedImage& source, PaddedImage& target, int begin, int end) const {
  RASTRO_CHECK(source.padding() >= 32 && target.padding() >= 32, "vectors read and write beyond a row");
  const std::size_t room = (blocks_.size() + 4) * block;
  std::vector<std::int16_t> shrunk(2 * room);
  int have[2] = {-1, -1};
  for (int y = begin; y < end; ++y) {
    const Row& row = rows_[static_cast<std::size_t>(y)];
    std::int16_t* of[2];
    for (int k = 0; k < 2; ++k) {
      const int wanted = row.above + k, slot = wanted % 2;
      of[k] = shrunk.data() + static_cast<std::size_t>(slot) * room;
      if (have[slot] != wanted) shrink_row(source.row(wanted), of[k]);
      have[slot] = wanted;
    }
    blend_rows(of[0], of[1], row.weight, width_, target.row(y));
  }
}

}  // namespace rastro
