// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/stereo_matching.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

/// Smooth texture that never repeats within the image, shifted to the left by `disparity`.
GrayImage textured(double disparity) {
  GrayImage image(480, 240);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double u = x + disparity;
      const double wave = std::sin(0.23 * u + 0.11 * y) + std::sin(0.19 * y - 0.013 * u * std::sin(0.05 * y)) +
                          std::sin(0.31 * u - 0.002 * u * y * 0.1);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(128.0 + 40.0 * wave));
    }
  }
  return image;
}

TEST(StereoMatching, DisparitiesAreAccurateToATenthOfAPixel) {
  constexpr double disparity = 12.3, focal_baseline = 246.0;
  const GrayImage left = textured(0.0), right = textured(disparity);
  OrbExtractor extractor(OrbOptions{.features = 400});
  ImageFeatures keyframe;
  keyframe.features = extractor.extract(left.view());
  ASSERT_GT(keyframe.features.size(), 100U);
  match_stereo(left.view(), right.view(), extractor.extract(right.view()), focal_baseline, {}, nullptr, keyframe);
  std::size_t known = 0, right_ones = 0;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (!(keyframe.depths[i] > 0.0F)) continue;
    ++known;
    right_ones += std::abs(focal_baseline / static_cast<double>(keyframe.depths[i]) - disparity) < 0.1 ? 1U : 0U;
    EXPECT_NEAR(static_cast<double>(keyframe.features.keypoints[i].x - keyframe.right_x[i]),
                focal_baseline / static_cast<double>(keyframe.depths[i]), 1e-3);
  }
  EXPECT_GT(known, keyframe.features.size() / 3);
  EXPECT_GT(right_ones, known * 9 / 10);
}

TEST(StereoMatching, AnImageOfAnotherSizeHasNoDepth) {
  const GrayImage left = textured(0.0);
  OrbExtractor extractor(OrbOptions{.features = 100});
  ImageFeatures keyframe;
  keyframe.features = extractor.extract(left.view());
  match_stereo(left.view(), GrayImage(100, 100).view(), {}, 100.0, {}, nullptr, keyframe);
  for (const float depth : keyframe.depths) EXPECT_EQ(depth, 0.0F);
}

}  // namespace
}  // namespace rastro
