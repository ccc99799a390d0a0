// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/disparity_refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

namespace rastro {
namespace {

constexpr int columns = 160, rows = 60;
constexpr double disparity_px = 12.3;

double texture(double u, double v) {
  return 40.0 * std::sin(0.45 * u + 0.1 * v) + 25.0 * std::sin(0.23 * u - 0.3 * v) + 15.0 * std::cos(0.8 * u);
}

using Brightness = std::function<double(double x, double y)>;

GrayImage image_of(const Brightness& brightness) {
  GrayImage image(columns, rows);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(brightness(x, y), 0.0, 255.0)));
  return image;
}

GrayImage left_image() {
  return image_of([](double x, double y) { return 120.0 + texture(x, y); });
}
/// Shows the left image's column x at x minus the disparity.
GrayImage right_image(double brighter = 0.0) {
  return image_of([=](double x, double y) { return 120.0 + brighter + texture(x + disparity_px, y); });
}

Image<float> constant(double disparity) {
  Image<float> image(columns, rows);
  for (int y = 0; y < rows; ++y) std::fill_n(image.row(y), columns, static_cast<float>(disparity));
  return image;
}

/// Of the pixels whose whole window both images show, ascending.
std::vector<float> inner(const Image<float>& disparity) {
  std::vector<float> found;
  for (int y = 8; y < rows - 8; ++y)
    for (int x = 30; x < columns - 12; ++x) found.push_back(disparity.at(x, y));
  std::sort(found.begin(), found.end());
  return found;
}

TEST(DisparityRefinement, FindsThePartOfAPixelFromEitherSideInAnyLight) {
  for (const double start : {11.6, 12.0, 13.0}) {
    for (const double brighter : {0.0, 20.0}) {
      Image<float> disparity = constant(start);
      refine_disparity(left_image().view(), right_image(brighter).view(), {}, disparity);
      const std::vector<float> found = inner(disparity);
      EXPECT_NEAR(found[found.size() / 2], disparity_px, 0.05) << start << ' ' << brighter;
      EXPECT_NEAR(found[found.size() / 20], disparity_px, 0.15) << start << ' ' << brighter;
      EXPECT_NEAR(found[found.size() * 19 / 20], disparity_px, 0.15) << start << ' ' << brighter;
    }
  }
}

TEST(DisparityRefinement, WithoutTextureTheDisparityStays) {
  const GrayImage gray = image_of([](double, double) { return 90.0; });
  Image<float> disparity = constant(12.0);
  refine_disparity(gray.view(), gray.view(), {}, disparity);
  EXPECT_EQ(inner(disparity).front(), 12.0F);
  EXPECT_EQ(inner(disparity).back(), 12.0F);
}

TEST(DisparityRefinement, WindowsThatShowSomethingElseLoseTheirDisparity) {
  const GrayImage other = image_of([](double x, double y) { return 120.0 + texture(2.0 * y + 7.0, 1.7 * x); });
  Image<float> disparity = constant(12.0);
  refine_disparity(left_image().view(), other.view(), {}, disparity);
  const std::vector<float> found = inner(disparity);
  EXPECT_EQ(found[found.size() * 19 / 20], 0.0F);
}

TEST(DisparityRefinement, WhatHasNoDisparityGetsNoneAndFewNeighborsSayNothing) {
  Image<float> disparity = constant(0.0);
  disparity.at(80, 30) = 12.0F;
  refine_disparity(left_image().view(), right_image().view(), {}, disparity);
  EXPECT_EQ(inner(disparity).back(), 0.0F);
  disparity = constant(12.0);
  disparity.at(80, 30) = 0.0F;
  refine_disparity(left_image().view(), right_image().view(), {}, disparity);
  EXPECT_EQ(disparity.at(80, 30), 0.0F);
  EXPECT_NEAR(disparity.at(82, 30), disparity_px, 0.15);
}

TEST(DisparityRefinement, DisparitiesThatLeaveTheRightImageAreDropped) {
  Image<float> disparity = constant(12.0);
  refine_disparity(left_image().view(), right_image().view(), {}, disparity);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < 6; ++x) EXPECT_EQ(disparity.at(x, y), 0.0F) << x << ' ' << y;
}

}  // namespace
}  // namespace rastro
