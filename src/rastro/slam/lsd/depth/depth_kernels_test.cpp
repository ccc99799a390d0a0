// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_kernels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Everything known, unknown and of very different certainty.
InverseDepthMap noise_depth(int width, int height, std::uint64_t seed) {
  Random random(seed);
  InverseDepthMap depth(width, height);
  for (int y = 2; y < height - 2; ++y)
    for (int x = 2; x < width - 2; ++x) {
      if (random.below(3) == 0) continue;
      depth.mean.at(x, y) = static_cast<float>(random.uniform(0.8, 1.2));
      depth.variance.at(x, y) = static_cast<float>(std::exp(random.uniform(-9.0, -2.0)));
    }
  return depth;
}

TEST(DepthKernels, SmoothToTheSameBytes) {
  for (const int width : {40, 41, 47}) {
    const InverseDepthMap depth = noise_depth(width, 20, 4);
    for (const int fewest : {1, 3, 9}) {
      const SmoothingOptions options{.border = 4, .fewest = fewest};
      for (int y = 4; y < 16; ++y) {
        std::vector<float> plain(static_cast<std::size_t>(width), -1.0F), fast = plain;
        depth_kernels_plain().smooth_row(depth, y, options, plain.data());
        depth_kernels_avx2().smooth_row(depth, y, options, fast.data());
        ASSERT_EQ(plain, fast) << "and nothing is written at the edges";
      }
    }
  }
}

TEST(DepthKernels, SmoothingIsTheMeanOfWhatAgrees) {
  InverseDepthMap depth(16, 16);
  const auto set = [&](int x, int y, float mean) {
    depth.mean.at(x, y) = mean;
    depth.variance.at(x, y) = 1e-4F;
  };
  set(8, 8, 1.0F);
  set(9, 8, 1.02F);
  set(8, 9, 1.01F);
  set(7, 8, 1.5F);
  std::vector<float> smoothed(16);
  SmoothingOptions options{.border = 4, .fewest = 3, .slant = 0.0F};
  depth_kernels().smooth_row(depth, 8, options, smoothed.data());
  EXPECT_NEAR(smoothed[8], 1.01, 1e-6) << "without what lies elsewhere";
  EXPECT_EQ(smoothed[7], 0.0F) << "alone";
  EXPECT_EQ(smoothed[10], 0.0F) << "not known";
  options.fewest = 4;
  depth_kernels().smooth_row(depth, 8, options, smoothed.data());
  EXPECT_EQ(smoothed[8], 0.0F);
}

}  // namespace
}  // namespace rastro
