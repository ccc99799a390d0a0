// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/image_shift.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

/// Waves, `aside` pixels to the right; 640 x 480.
GrayImage waves(double aside) {
  GrayImage image(640, 480);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      image.at(x, y) = static_cast<std::uint8_t>(
          std::lround(128.0 + 60.0 * std::sin((x - aside) / 30.0) + 50.0 * std::sin(y / 25.0)));
  return image;
}

DepthImage waves_of_depth(double aside) {
  DepthImage depth(640, 480);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      depth.at(x, y) = x < 100 ? 0.0F : static_cast<float>(1.0 / (0.6 + 0.2 * std::sin((x - aside) / 30.0)));
  return depth;
}

TEST(ImageShift, IsThatOfImageAndDepth) {
  const Eigen::Vector2d of_image = shift_between(thumbnail_of(waves(0.0)), thumbnail_of(waves(4.0)));
  EXPECT_NEAR(of_image.x(), 0.5, 0.05) << "cells of 8 pixels";
  EXPECT_NEAR(of_image.y(), 0.0, 0.05);
  EXPECT_NEAR(shift_between(thumbnail_of(waves_of_depth(0.0)), thumbnail_of(waves_of_depth(-4.0))).x(), -0.5, 0.05);
}

TEST(ImageShift, IsNoneWithoutStructureOrSize) {
  EXPECT_TRUE(shift_between(thumbnail_of(GrayImage(640, 480)), thumbnail_of(GrayImage(640, 480))).isZero());
  EXPECT_TRUE(shift_between(thumbnail_of(DepthImage(640, 480)), thumbnail_of(DepthImage(640, 480))).isZero());
  EXPECT_TRUE(shift_between(thumbnail_of(GrayImage(3, 2)), thumbnail_of(GrayImage(3, 2))).isZero());
  EXPECT_TRUE(shift_between(thumbnail_of(waves(0.0)), thumbnail_of(GrayImage())).isZero());
}

}  // namespace
}  // namespace rastro
