// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/depth_kernels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"

namespace rastro {
namespace {

GrayImage noise_image(int width, int height, std::uint64_t seed) {
  Random random(seed);
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at(x, y) = static_cast<std::uint8_t>(random.below(256));
  return image;
}

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

TEST(DepthKernels, SampleLinesToTheSameBytes) {
  const GrayImage image = noise_image(83, 61, 1);
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    LineSampling line{image.view()};
    line.count = 1 + static_cast<int>(random.below(most_line_steps + epipolar_samples - 1));
    const auto from_x = static_cast<float>(random.uniform(0.0, 81.9)),
               from_y = static_cast<float>(random.uniform(0.0, 59.9));
    const auto to_x = static_cast<float>(random.uniform(0.0, 81.9)),
               to_y = static_cast<float>(random.uniform(0.0, 59.9));
    line.x = from_x, line.y = from_y;
    line.step_x = (to_x - from_x) / static_cast<float>(line.count);
    line.step_y = (to_y - from_y) / static_cast<float>(line.count);
    LineIntensities plain{}, fast{};
    depth_kernels_plain().sample(line, plain);
    depth_kernels_avx2().sample(line, fast);
    for (int k = 0; k < line.count; ++k) {
      const auto index = static_cast<std::size_t>(k);
      ASSERT_EQ(plain[index], fast[index]) << i << " " << k;
    }
  }
}

TEST(DepthKernels, SamplesAreBilinear) {
  GrayImage image(16, 8);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x) image.at(x, y) = static_cast<std::uint8_t>(3 * x + 20 * y);
  LineIntensities intensities{};
  depth_kernels().sample({image.view(), 1.25F, 2.5F, 0.5F, 0.25F, 9}, intensities);
  for (int i = 0; i < 9; ++i)
    EXPECT_NEAR(intensities[static_cast<std::size_t>(i)], 3.0 * (1.25 + 0.5 * i) + 20.0 * (2.5 + 0.25 * i), 1e-4);
}

TEST(DepthKernels, CompareToTheSameBytesAndToTheDefinition) {
  Random random(3);
  LineIntensities intensities{};
  for (float& each : intensities) each = static_cast<float>(random.uniform(0.0, 255.0));
  std::array<float, epipolar_samples> seen{};
  for (float& each : seen) each = static_cast<float>(random.uniform(0.0, 255.0));
  for (const int count : {1, 7, 8, 9, most_line_steps}) {
    LineCosts plain{}, fast{};
    depth_kernels_plain().compare(intensities, seen, count, plain);
    depth_kernels_avx2().compare(intensities, seen, count, fast);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      ASSERT_EQ(plain[i], fast[i]);
      double squares = 0.0;
      for (std::size_t k = 0; k < seen.size(); ++k)
        squares += std::pow(static_cast<double>(intensities[i + k] - seen[k]), 2);
      EXPECT_NEAR(plain[i], squares / epipolar_samples, 1e-6 * squares);
    }
  }
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
