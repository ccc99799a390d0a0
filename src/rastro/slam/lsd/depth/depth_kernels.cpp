// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_kernels.h"

#include <algorithm>

#include "rastro/base/simd.h"

namespace rastro {
namespace {

// Every expression below has a twin in depth_kernels_avx2.cpp that rounds in the same order.

/// 0 where fewer neighbors agree.
float smoothed_mean(const InverseDepthMap& depth, int x, int y, const SmoothingOptions& options) {
  constexpr int reach = 2;
  const float own = depth.mean.at(x, y), own_variance = depth.variance.at(x, y);
  const float slant = options.slant * own, slant_variance = slant * slant;
  const float most = options.max_sigmas * options.max_sigmas;
  float sum = 0.0F, weights = 0.0F;
  int count = 0;
  for (int v = std::max(options.border, y - reach); v <= std::min(depth.height() - 1 - options.border, y + reach); ++v)
    for (int u = x - reach; u <= x + reach; ++u) {
      const float mean = depth.mean.at(u, v), variance = depth.variance.at(u, v), difference = own - mean;
      if (!(variance > 0.0F) || !(difference * difference <= most * (own_variance + variance))) continue;
      // A pixel farther away may lie on a slanted surface.
      const auto distance = static_cast<float>((u - x) * (u - x) + (v - y) * (v - y));
      const float weight = 1.0F / (variance + distance * slant_variance);
      sum = sum + weight * mean;
      weights = weights + weight;
      ++count;
    }
  return count >= options.fewest ? sum / weights : 0.0F;
}

void smooth_row_plain(const InverseDepthMap& depth, int y, const SmoothingOptions& options, float* smoothed) {
  for (int x = options.border; x < depth.width() - options.border; ++x)
    smoothed[x] = depth.is_known(x, y) ? smoothed_mean(depth, x, y, options) : 0.0F;
}

}  // namespace

const DepthKernels& depth_kernels_plain() {
  static const DepthKernels kernels{smooth_row_plain};
  return kernels;
}

const DepthKernels& depth_kernels() {
  return simd_level() == SimdLevel::avx2 ? depth_kernels_avx2() : depth_kernels_plain();
}

}  // namespace rastro
