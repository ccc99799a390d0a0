// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_kernels.h"

#include <algorithm>

#include "rastro/base/simd.h"

namespace rastro {
namespace {

// Every expression below has a twin in depth_kernels_avx2.cpp that rounds in the same order.

void sample_plain(const LineSampling& line, LineIntensities& intensities) {
  for (int i = 0; i < line.count; ++i) {
    const float x = line.x + static_cast<float>(i) * line.step_x, y = line.y + static_cast<float>(i) * line.step_y;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const float right = x - static_cast<float>(column), low = y - static_cast<float>(row);
    const std::uint8_t *above = line.image.row(row) + column, *below = line.image.row(row + 1) + column;
    const auto between = [right](const std::uint8_t* pixel) {
      const auto left = static_cast<float>(pixel[0]);
      return left + right * (static_cast<float>(pixel[1]) - left);
    };
    const float upper = between(above);
    intensities[static_cast<std::size_t>(i)] = upper + low * (between(below) - upper);
  }
}

void compare_plain(const LineIntensities& intensities, const std::array<float, epipolar_samples>& seen, int count,
                   LineCosts& costs) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    float squares = 0.0F;
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const float difference = intensities[i + k] - seen[k];
      squares = squares + difference * difference;
    }
    costs[i] = squares * (1.0F / epipolar_samples);
  }
}

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
  static const DepthKernels kernels{sample_plain, compare_plain, smooth_row_plain};
  return kernels;
}

const DepthKernels& depth_kernels() {
  return simd_level() == SimdLevel::avx2 ? depth_kernels_avx2() : depth_kernels_plain();
}

}  // namespace rastro
