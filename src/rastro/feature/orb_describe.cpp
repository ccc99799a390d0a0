// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/orb_describe.h"

#include <cmath>
#include <cstdlib>

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int rows = 2 * orb_radius + 1;
constexpr int bits = 14;  // Fraction bits of a cosine.

/// Ends of the tests as pairs of 16 bits, so that one multiplication rotates eight of them.
struct alignas(32) Ends {
  std::array<std::int16_t, 512> first{}, second{};
};

const Ends& ends() {
  static const Ends made = [] {
    Ends filled;
    for (std::size_t t = 0; t < 256; ++t) {
      const auto& test = orb_pattern()[t];
      filled.first[2 * t] = test[0];
      filled.first[2 * t + 1] = test[1];
      filled.second[2 * t] = test[2];
      filled.second[2 * t + 1] = test[3];
    }
    return filled;
  }();
  return made;
}

/// Half width of the disc in each of its rows.
int half_width(int dy) { return static_cast<int>(std::sqrt(orb_radius * (orb_radius + 1) - dy * dy)); }

struct Moments {
  int x = 0, y = 0;
};

Moments moments_plain(const std::uint8_t* center, std::ptrdiff_t stride) {
  Moments moments;
  for (int dy = -orb_radius; dy <= orb_radius; ++dy) {
    const int half = half_width(dy);
    for (int dx = -half; dx <= half; ++dx) {
      const int intensity = center[dy * stride + dx];
      moments.x += dx * intensity;
      moments.y += dy * intensity;
    }
  }
  return moments;
}

/// Position of a rotated end in the image.
std::ptrdiff_t offset_of(const std::int16_t* end, const OrbDirection& direction, std::ptrdiff_t stride) {
  constexpr int half = 1 << (bits - 1);
  const int x = (end[0] * direction.cosine - end[1] * direction.sine + half) >> bits;
  const int y = (end[0] * direction.sine + end[1] * direction.cosine + half) >> bits;
  return y * stride + x;
}

Descriptor describe_plain(const std::uint8_t* center, std::ptrdiff_t stride, const OrbDirection& direction) {
  Descriptor descriptor;
  for (std::size_t t = 0; t < 256; ++t) {
    const bool below = center[offset_of(&ends().first[2 * t], direction, stride)] <
                       center[offset_of(&ends().second[2 * t], direction, stride)];
    descriptor.words[t / 64] |= static_cast<std::uint64_t>(below) << (t % 64);
  }
  return descriptor;
}

#if RASTRO_HAS_AVX2_CODE
/// For each row of the disc: which bytes belong to it.
struct alignas(32) DiscMasks {
  std::array<std::array<std::uint8_t, 32>, rows> row{};
};

const DiscMasks& disc_masks() {
  static const DiscMasks made = [] {
    DiscMasks filled;
    for (int dy = -orb_radius; dy <= orb_radius; ++dy)
      for (int dx = -half_width(dy); dx <= half_width(dy); ++dx)
        filled.row[static_cast<std::size_t>(dy + orb_radius)][static_cast<std::size_t>(dx + orb_radius)] = 255;
    return filled;
  }();
  return made;
}

RASTRO_TARGET_AVX2 inline int sum_of(__m256i values) {
  __m128i sum = _mm_add_epi32(_mm256_castsi256_si128(values), _mm256_extracti128_si256(values, 1));
  sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0b01001110));
  return _mm_cvtsi128_si32(_mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0b10110001)));
}

RASTRO_TARGET_AVX2 Moments moments_avx2(const std::uint8_t* center, std::ptrdiff_t stride, const DiscMasks& masks) {
  const __m256i across = _mm256_setr_epi8(-15, -14, -13, -12, -11, -10, -9, -8, -7, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3,
                                          4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0);
  const __m256i ones = _mm256_set1_epi16(1), zero = _mm256_setzero_si256();
  __m256i moment_x = zero, moment_y = zero;
  for (int dy = -orb_radius; dy <= orb_radius; ++dy) {
    const __m256i mask =
        _mm256_load_si256(reinterpret_cast<const __m256i*>(&masks.row[static_cast<std::size_t>(dy + orb_radius)]));
    const __m256i pixels =
        _mm256_and_si256(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(center + dy * stride - orb_radius)), mask);
    moment_x = _mm256_add_epi32(moment_x, _mm256_madd_epi16(_mm256_maddubs_epi16(pixels, across), ones));
    const __m256i sums = _mm256_sad_epu8(pixels, zero);  // Four sums below 2^11, 64 bits each.
    moment_y = _mm256_add_epi32(moment_y, _mm256_madd_epi16(sums, _mm256_set1_epi16(static_cast<short>(dy))));
  }
  return {sum_of(moment_x), sum_of(moment_y)};
}

/// Values of eight rotated ends; reads three bytes behind each too, which the image's slack allows.
RASTRO_TARGET_AVX2 inline __m256i values_at(const std::int16_t* ends, const std::uint8_t* center, __m256i to_x,
                                            __m256i to_y, __m256i strides) {
  const __m256i half = _mm256_set1_epi32(1 << (bits - 1));
  const __m256i end = _mm256_load_si256(reinterpret_cast<const __m256i*>(ends));
  const __m256i x = _mm256_srai_epi32(_mm256_add_epi32(_mm256_madd_epi16(end, to_x), half), bits);
  const __m256i y = _mm256_srai_epi32(_mm256_add_epi32(_mm256_madd_epi16(end, to_y), half), bits);
  const __m256i offsets = _mm256_add_epi32(_mm256_mullo_epi32(y, strides), x);
  return _mm256_and_si256(_mm256_i32gather_epi32(reinterpret_cast<const int*>(center), offsets, 1),
                          _mm256_set1_epi32(0xff));
}

RASTRO_TARGET_AVX2 Descriptor describe_avx2(const std::uint8_t* center, std::ptrdiff_t stride,
                                            const OrbDirection& direction, const Ends& ends) {
  const __m256i cosine = _mm256_set1_epi16(direction.cosine), sine = _mm256_set1_epi16(direction.sine);
  const __m256i minus_sine = _mm256_sub_epi16(_mm256_setzero_si256(), sine);
  const __m256i to_x = _mm256_blend_epi16(cosine, minus_sine, 0b10101010);
  const __m256i to_y = _mm256_blend_epi16(sine, cosine, 0b10101010);
  const __m256i strides = _mm256_set1_epi32(static_cast<int>(stride));
  Descriptor descriptor;
  for (std::size_t t = 0; t < 256; t += 8) {
    const __m256i first = values_at(ends.first.data() + 2 * t, center, to_x, to_y, strides);
    const __m256i second = values_at(ends.second.data() + 2 * t, center, to_x, to_y, strides);
    const int below = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(second, first)));
    descriptor.words[t / 64] |= static_cast<std::uint64_t>(static_cast<unsigned>(below)) << (t % 64);
  }
  return descriptor;
}
#endif

Moments moments_of(const std::uint8_t* center, std::ptrdiff_t stride) {
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) return moments_avx2(center, stride, disc_masks());
#endif
  return moments_plain(center, stride);
}

}  // namespace

OrbDirection orb_direction(const std::uint8_t* center, std::ptrdiff_t stride) {
  const Moments moments = moments_of(center, stride);
  const double x = moments.x, y = moments.y;
  const double length = std::sqrt(x * x + y * y);
  if (length == 0.0) return {};
  return {static_cast<std::int16_t>(std::lround(x / length * (1 << bits))),
          static_cast<std::int16_t>(std::lround(y / length * (1 << bits))), static_cast<float>(std::atan2(y, x))};
}

Descriptor orb_describe(const std::uint8_t* center, std::ptrdiff_t stride, const OrbDirection& direction) {
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) return describe_avx2(center, stride, direction, ends());
#endif
  return describe_plain(center, stride, direction);
}

}  // namespace rastro
