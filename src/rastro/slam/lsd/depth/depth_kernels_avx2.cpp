// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "rastro/base/simd.h"
#include "rastro/slam/lsd/depth/depth_kernels.h"

#if RASTRO_HAS_AVX2_CODE
#include "rastro/slam/lsd/avx2_lanes.h"
#endif

namespace rastro {

#if RASTRO_HAS_AVX2_CODE
namespace {

// Every expression below has a twin in depth_kernels.cpp that rounds in the same order.

using lanes::add, lanes::all, lanes::mul, lanes::sub;

struct EightSums {
  __m256 sum, weights, count;
};

/// Adds one neighbor of each of eight pixels of a row.
RASTRO_TARGET_AVX2 inline void add_neighbors(__m256 mean, __m256 variance, __m256 own, __m256 own_variance,
                                             __m256 slant_variance, __m256 most, EightSums& sums) {
  const __m256 difference = sub(own, mean);
  const __m256 known = _mm256_cmp_ps(variance, _mm256_setzero_ps(), _CMP_GT_OQ);
  const __m256 agrees = _mm256_cmp_ps(mul(difference, difference), mul(most, add(own_variance, variance)), _CMP_LE_OQ);
  const __m256 used = _mm256_and_ps(known, agrees);
  const __m256 weight = _mm256_and_ps(_mm256_div_ps(all(1.0F), add(variance, slant_variance)), used);
  sums.sum = add(sums.sum, mul(weight, mean));
  sums.weights = add(sums.weights, weight);
  sums.count = add(sums.count, _mm256_and_ps(all(1.0F), used));
}

RASTRO_TARGET_AVX2 inline __m256 smooth_eight(const InverseDepthMap& depth, int x, int y,
                                              const SmoothingOptions& options) {
  constexpr int reach = 2;
  const __m256 own = _mm256_loadu_ps(depth.mean.row(y) + x), own_variance = _mm256_loadu_ps(depth.variance.row(y) + x);
  const __m256 known = _mm256_cmp_ps(own_variance, _mm256_setzero_ps(), _CMP_GT_OQ);
  if (_mm256_movemask_ps(known) == 0) return _mm256_setzero_ps();
  const __m256 slant = mul(all(options.slant), own), slant_variance = mul(slant, slant);
  const __m256 most = all(options.max_sigmas * options.max_sigmas);
  EightSums sums{_mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps()};
  for (int v = std::max(options.border, y - reach); v <= std::min(depth.height() - 1 - options.border, y + reach); ++v)
    for (int du = -reach; du <= reach; ++du) {
      const auto distance = static_cast<float>(du * du + (v - y) * (v - y));
      add_neighbors(_mm256_loadu_ps(depth.mean.row(v) + x + du), _mm256_loadu_ps(depth.variance.row(v) + x + du), own,
                    own_variance, mul(all(distance), slant_variance), most, sums);
    }
  const __m256 enough = _mm256_cmp_ps(sums.count, all(static_cast<float>(options.fewest)), _CMP_GE_OQ);
  return _mm256_and_ps(_mm256_div_ps(sums.sum, sums.weights), _mm256_and_ps(known, enough));
}

/// The last pixels of a row are read with what follows it in memory, and not written.
RASTRO_TARGET_AVX2 void smooth_row_avx2(const InverseDepthMap& depth, int y, const SmoothingOptions& options,
                                        float* smoothed) {
  const int end = depth.width() - options.border;
  for (int x = options.border; x < end; x += 8) {
    alignas(32) float eight[8];
    _mm256_store_ps(eight, smooth_eight(depth, x, y, options));
    std::copy(eight, eight + std::min(8, end - x), smoothed + x);
  }
}

}  // namespace

const DepthKernels& depth_kernels_avx2() {
  static const DepthKernels kernels{smooth_row_avx2};
  return kernels;
}
#else
const DepthKernels& depth_kernels_avx2() { return depth_kernels_plain(); }
#endif

}  // namespace rastro
