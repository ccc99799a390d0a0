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

using lanes::add, lanes::all, lanes::between, lanes::mul, lanes::sub;

RASTRO_TARGET_AVX2 void sample_avx2(const LineSampling& line, LineIntensities& intensities) {
  const auto stride = static_cast<int>(line.image.stride);
  const int* words = reinterpret_cast<const int*>(line.image.data);
  const int* next_words = reinterpret_cast<const int*>(line.image.data + stride);
  const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), last = _mm256_set1_epi32(line.count - 1);
  for (int i = 0; i < line.count; i += 8) {
    // Lanes past the end repeat the last sample.
    const __m256 step = _mm256_cvtepi32_ps(_mm256_min_epi32(_mm256_add_epi32(_mm256_set1_epi32(i), lanes), last));
    const __m256 x = add(all(line.x), mul(step, all(line.step_x))), y = add(all(line.y), mul(step, all(line.step_y)));
    const __m256i column = _mm256_cvttps_epi32(x), row = _mm256_cvttps_epi32(y);
    const __m256 right = sub(x, _mm256_cvtepi32_ps(column)), low = sub(y, _mm256_cvtepi32_ps(row));
    const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(row, _mm256_set1_epi32(stride)), column);
    const __m256 upper = between(_mm256_i32gather_epi32(words, at, 1), right);
    const __m256 lower = between(_mm256_i32gather_epi32(next_words, at, 1), right);
    _mm256_storeu_ps(&intensities[static_cast<std::size_t>(i)], add(upper, mul(low, sub(lower, upper))));
  }
}

RASTRO_TARGET_AVX2 void compare_avx2(const LineIntensities& intensities,
                                     const std::array<float, epipolar_samples>& seen, int count, LineCosts& costs) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); i += 8) {
    __m256 squares = _mm256_setzero_ps();
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const __m256 difference = sub(_mm256_loadu_ps(&intensities[i + k]), all(seen[k]));
      squares = add(squares, mul(difference, difference));
    }
    _mm256_storeu_ps(&costs[i], mul(squares, all(1.0F / epipolar_samples)));
  }
}

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
  static const DepthKernels kernels{sample_avx2, compare_avx2, smooth_row_avx2};
  return kernels;
}
#else
const DepthKernels& depth_kernels_avx2() { return depth_kernels_plain(); }
#endif

}  // namespace rastro
