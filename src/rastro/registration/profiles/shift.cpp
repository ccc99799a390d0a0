// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/shift.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "rastro/base/error.h"
#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

std::int64_t sum_plain(const std::int16_t* a, const std::int16_t* b, int count) {
  std::int64_t sum = 0;
  for (int i = 0; i < count; ++i) sum += std::abs(a[i] - b[i]);
  return sum;
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 std::int64_t sum_avx2(const std::int16_t* a, const std::int16_t* b, int count) {
  // A lane gains less than 2^16 per step: the number of steps that fit it.
  constexpr int block = 16 * 16384;
  const __m256i ones = _mm256_set1_epi16(1);
  std::int64_t total = 0;
  int i = 0;
  while (i + 16 <= count) {
    const int end = std::min(count, i + block);
    __m256i sums = _mm256_setzero_si256();
    for (; i + 16 <= end; i += 16) {
      const __m256i difference = _mm256_sub_epi16(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(a + i)),
                                                  _mm256_loadu_si256(reinterpret_cast<const __m256i*>(b + i)));
      sums = _mm256_add_epi32(sums, _mm256_madd_epi16(_mm256_abs_epi16(difference), ones));
    }
    alignas(32) std::int32_t lanes[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(lanes), sums);
    for (const std::int32_t lane : lanes) total += lane;
  }
  return total + sum_plain(a + i, b + i, count - i);
}
#endif

/// p(d) for d = -max_shift .. max_shift, intensity levels.
std::vector<double> differences(const Profile& previous, const Profile& current, int max_shift) {
  const int size = static_cast<int>(previous.size());
  std::vector<double> p;
  p.reserve(static_cast<std::size_t>(2 * max_shift + 1));
  for (int d = -max_shift; d <= max_shift; ++d) {
    const int overlap = size - std::abs(d);
    const auto sum = sum_of_differences(current.data() + std::max(d, 0), previous.data() - std::min(d, 0), overlap);
    p.push_back(static_cast<double>(sum) / overlap / profile_units);
  }
  return p;
}

std::size_t lowest_nearest_to_zero(const std::vector<double>& p, int max_shift) {
  std::size_t best = static_cast<std::size_t>(max_shift);
  for (int distance = 1; distance <= max_shift; ++distance) {
    for (const int d : {-distance, distance}) {
      const auto at = static_cast<std::size_t>(d + max_shift);
      if (p[at] < p[best]) best = at;
    }
  }
  return best;
}

/// The lowest local minimum other than the one at `best`, but no more than `mean`.
double best_rival(const std::vector<double>& p, std::size_t best, double mean) {
  double rival = mean;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool below_left = i == 0 || p[i] <= p[i - 1];
    const bool below_right = i + 1 == p.size() || p[i] <= p[i + 1];
    // Next to the minimum, noise makes local minima that are no competitors.
    const auto distance = i > best ? i - best : best - i;
    if (below_left && below_right && distance > 2) rival = std::min(rival, p[i]);
  }
  return rival;
}

}  // namespace

std::int64_t sum_of_differences(const std::int16_t* a, const std::int16_t* b, int count) {
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) return sum_avx2(a, b, count);
#endif
  return sum_plain(a, b, count);
}

ProfileShift find_shift(const Profile& previous, const Profile& current, int max_shift) {
  RASTRO_CHECK(previous.size() == current.size(), "profiles of one length");
  max_shift = std::min(max_shift, static_cast<int>(previous.size()) / 2);
  if (max_shift < 1) return {};
  return lowest_of(differences(previous, current, max_shift));
}

ProfileShift lowest_of(const std::vector<double>& p) {
  const int max_shift = static_cast<int>(p.size() / 2);
  ProfileShift result;
  const std::size_t best = lowest_nearest_to_zero(p, max_shift);
  result.shift = static_cast<double>(best) - max_shift;
  result.residual = p[best];
  result.at_zero = p[static_cast<std::size_t>(max_shift)];
  result.mean = std::accumulate(p.begin(), p.end(), 0.0) / static_cast<double>(p.size());
  if (best == 0 || best + 1 == p.size() || result.mean <= 0.0) return result;
  const double curvature = p[best - 1] - 2.0 * p[best] + p[best + 1];
  if (curvature > 0.0) result.shift += 0.5 * (p[best - 1] - p[best + 1]) / curvature;
  result.sharpness = curvature / result.mean;
  const double rival = best_rival(p, best, result.mean);
  if (rival > 0.0) result.confidence = std::max(0.0, 1.0 - p[best] / rival);
  return result;
}

}  // namespace rastro
