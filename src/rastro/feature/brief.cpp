// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/brief.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/random.h"
#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int angles = 32;
constexpr std::size_t tests = 256;

std::vector<BriefTest> draw_tests(int patch_px, std::uint64_t seed) {
  Random random(seed);
  const double sigma = patch_px / 5.0;
  const double limit = patch_px / 2.0;
  const auto draw = [&] { return static_cast<float>(std::clamp(sigma * random.normal(), -limit, limit)); };
  std::vector<BriefTest> drawn;
  while (drawn.size() < tests) {
    BriefTest test{};
    test.ax = draw();
    test.ay = draw();
    test.bx = draw();
    test.by = draw();
    // A test with both ends on one pixel has no information.
    if (std::lround(test.ax) != std::lround(test.bx) || std::lround(test.ay) != std::lround(test.by))
      drawn.push_back(test);
  }
  return drawn;
}

}  // namespace

int hamming_distance(const Descriptor& a, const Descriptor& b) {
  // Without the instruction, which not every x86 has, std::popcount is a slow call.
  constexpr std::uint64_t ones = 0x0101010101010101;
  std::uint64_t bytes = 0;  // Of each byte of all words together: how many bits differ.
  for (std::size_t i = 0; i < 4; ++i) {
    std::uint64_t bits = a.words[i] ^ b.words[i];
    bits -= bits >> 1 & 0x55 * ones;
    bits = (bits & 0x33 * ones) + (bits >> 2 & 0x33 * ones);
    bytes += (bits + (bits >> 4)) & 0x0f * ones;
  }
  constexpr std::uint64_t every_second_byte = 0x00ff00ff00ff00ff;
  bytes = (bytes & every_second_byte) + (bytes >> 8 & every_second_byte);
  return static_cast<int>(bytes * 0x0001000100010001 >> 48);
}

const std::vector<double>& Brief::scales() {
  // The plain pattern first, then steps of about a quarter in both directions.
  static const std::vector<double> steps = {1.0, 0.8, 1.25, 0.64, 1.5625};
  return steps;
}

Brief::Brief(int patch_px, std::uint64_t seed) {
  RASTRO_CHECK(patch_px >= 8 && patch_px <= 64, "offsets of all scales fit a byte");
  const auto drawn = draw_tests(patch_px, seed);
  for (const double scale : scales()) {
    for (int angle = 0; angle < angles; ++angle) {
      const double angle_rad = 2.0 * std::numbers::pi * angle / angles;
      const double cosine = scale * std::cos(angle_rad), sine = scale * std::sin(angle_rad);
      Pattern pattern{};
      const auto rotate = [&](double x, double y, std::int8_t& to_x, std::int8_t& to_y) {
        to_x = static_cast<std::int8_t>(std::lround(cosine * x - sine * y));
        to_y = static_cast<std::int8_t>(std::lround(sine * x + cosine * y));
        reach_ = std::max({reach_, std::abs(int{to_x}), std::abs(int{to_y})});
      };
      for (std::size_t t = 0; t < drawn.size(); ++t) {
        rotate(drawn[t].ax, drawn[t].ay, pattern.ax[t], pattern.ay[t]);
        rotate(drawn[t].bx, drawn[t].by, pattern.bx[t], pattern.by[t]);
      }
      patterns_.push_back(pattern);
    }
  }
}

const Brief::Pattern& Brief::pattern_of(double angle_rad, double scale) const {
  const auto nearest_scale = std::min_element(
      scales().begin(), scales().end(), [&](double a, double b) { return std::abs(a - scale) < std::abs(b - scale); });
  const auto angle_steps = std::lround(angle_rad * angles / (2.0 * std::numbers::pi));
  const auto angle_index = ((angle_steps % angles) + angles) % angles;
  return patterns_[static_cast<std::size_t>((nearest_scale - scales().begin()) * angles + angle_index)];
}

Descriptor Brief::describe(const Image<std::uint16_t>& sums, float x, float y, double angle_rad, double scale) const {
  const Pattern& pattern = angle_rad == 0.0 && scale == 1.0 ? patterns_.front() : pattern_of(angle_rad, scale);
  const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
  if (cx >= reach_ && cy >= reach_ && cx + reach_ < sums.width() && cy + reach_ < sums.height()) {
    const std::uint16_t* center = sums.row(cy) + cx;
    return simd_level() == SimdLevel::avx2 ? compare_avx2(pattern, center, sums.stride())
                                           : compare_plain(pattern, center, sums.stride());
  }
  Descriptor descriptor;
  const auto value = [&](int dx, int dy) {
    return sums.at(std::clamp(cx + dx, 0, sums.width() - 1), std::clamp(cy + dy, 0, sums.height() - 1));
  };
  for (std::size_t t = 0; t < tests; ++t) {
    const bool below = value(pattern.ax[t], pattern.ay[t]) < value(pattern.bx[t], pattern.by[t]);
    descriptor.words[t / 64] |= static_cast<std::uint64_t>(below) << (t % 64);
  }
  return descriptor;
}

Descriptor Brief::compare_plain(const Pattern& pattern, const std::uint16_t* center, std::ptrdiff_t stride) {
  Descriptor descriptor;
  for (std::size_t t = 0; t < tests; ++t) {
    const bool below = center[pattern.ay[t] * stride + pattern.ax[t]] < center[pattern.by[t] * stride + pattern.bx[t]];
    descriptor.words[t / 64] |= static_cast<std::uint64_t>(below) << (t % 64);
  }
  return descriptor;
}

#if RASTRO_HAS_AVX2_CODE
namespace {

RASTRO_TARGET_AVX2 inline __m256i widened(const std::int8_t* values) {
  return _mm256_cvtepi8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(values)));
}

/// Eight values at once; each read takes two bytes too many, which the image's slack allows.
RASTRO_TARGET_AVX2 inline __m256i values_at(const std::uint16_t* center, __m256i stride, const std::int8_t* x,
                                            const std::int8_t* y) {
  const __m256i offsets = _mm256_add_epi32(_mm256_mullo_epi32(widened(y), stride), widened(x));
  const __m256i read = _mm256_i32gather_epi32(reinterpret_cast<const int*>(center), offsets, sizeof(std::uint16_t));
  return _mm256_and_si256(read, _mm256_set1_epi32(0xffff));
}

}  // namespace

RASTRO_TARGET_AVX2 Descriptor Brief::compare_avx2(const Pattern& pattern, const std::uint16_t* center,
                                                  std::ptrdiff_t stride) {
  Descriptor descriptor;
  const __m256i strides = _mm256_set1_epi32(static_cast<int>(stride));
  for (std::size_t t = 0; t < tests; t += 8) {
    const __m256i a = values_at(center, strides, pattern.ax.data() + t, pattern.ay.data() + t);
    const __m256i b = values_at(center, strides, pattern.bx.data() + t, pattern.by.data() + t);
    const int below = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(b, a)));
    descriptor.words[t / 64] |= static_cast<std::uint64_t>(static_cast<unsigned>(below)) << (t % 64);
  }
  return descriptor;
}
#else
Descriptor Brief::compare_avx2(const Pattern& pattern, const std::uint16_t* center, std::ptrdiff_t stride) {
  return compare_plain(pattern, center, stride);
}
#endif

double intensity_centroid_angle(GrayView image, float x, float y, int radius) {
  const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
  std::int64_t moment_x = 0, moment_y = 0;
  for (int dy = -radius; dy <= radius; ++dy) {
    const std::uint8_t* row = image.row(std::clamp(cy + dy, 0, image.height - 1));
    for (int dx = -radius; dx <= radius; ++dx) {
      if (dx * dx + dy * dy > radius * radius) continue;
      const int intensity = row[std::clamp(cx + dx, 0, image.width - 1)];
      moment_x += dx * intensity;
      moment_y += dy * intensity;
    }
  }
  return std::atan2(static_cast<double>(moment_y), static_cast<double>(moment_x));
}

}  // namespace rastro
