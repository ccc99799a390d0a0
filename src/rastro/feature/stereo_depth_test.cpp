// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/stereo_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr int columns = 320, rows = 160;
constexpr double focal_px = 250.0, baseline = 0.2;

/// A smooth texture without repetition: waves of random length and phase.
double brightness(double u, double v) {
  double sum = 0.0;
  Random random(3);
  for (int wave = 0; wave < 24; ++wave) {
    const double angle = M_PI * random.uniform(), per_px = 2.0 * M_PI / (4.0 + 12.0 * random.uniform());
    sum += std::sin(per_px * (std::cos(angle) * u + std::sin(angle) * v) + 2.0 * M_PI * random.uniform());
  }
  return 128.0 + 20.0 * sum;
}

GrayImage image_of(double (*left_column)(double x), double contrast = 1.0) {
  GrayImage image(columns, rows);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const double value = 128.0 + contrast * (brightness(left_column(x), y) - 128.0);
      image.at(x, y) = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
    }
  }
  return image;
}

// Inverse depth is linear in the image on any plane: this one leads from 2.5 m at the left border to 1.3 m.
double disparity_at(double left_x) { return focal_px * baseline * (0.4 + 0.37 * left_x / columns); }
double exact_depth(double left_x) { return focal_px * baseline / disparity_at(left_x); }
double same_column(double x) { return x; }
/// Where the left image shows what the right one shows in column x: x = left - disparity(left).
double left_of_right(double x) {
  const double at_border = focal_px * baseline * 0.4, slope = focal_px * baseline * 0.37 / columns;
  return (x + at_border) / (1.0 - slope);
}

StereoDepthOptions options_of(double least_px, int most_px) { return {focal_px * baseline, least_px, most_px}; }

TEST(StereoDepth, ASlantedPlaneHasItsExactDepths) {
  const StereoDepth stereo(options_of(2.0, 48));
  const DepthImage depth = stereo.depth(image_of(same_column).view(), image_of(left_of_right).view());
  std::vector<double> off_px;
  int seen = 0;
  for (int y = 20; y < rows - 20; ++y) {
    for (int x = 64; x < columns - 20; ++x, ++seen) {
      if (depth.at(x, y) == 0.0F) continue;
      off_px.push_back(std::abs(focal_px * baseline / static_cast<double>(depth.at(x, y)) - disparity_at(x)));
    }
  }
  ASSERT_GT(static_cast<double>(off_px.size()), 0.9 * seen);
  std::sort(off_px.begin(), off_px.end());
  EXPECT_LT(off_px[off_px.size() / 2], 0.1);
  EXPECT_LT(off_px[off_px.size() * 99 / 100], 0.3);
  EXPECT_NEAR(depth.at(200, 80), exact_depth(200.0), 0.02);
}

int with_depth(const DepthImage& depth) {
  int count = 0;
  for (int y = 0; y < depth.height(); ++y)
    count += static_cast<int>(std::count_if(depth.row(y), depth.row(y) + depth.width(), [](float z) { return z > 0; }));
  return count;
}

TEST(StereoDepth, WithoutTextureOrCorrespondenceThereIsNoDepth) {
  const StereoDepth stereo(options_of(2.0, 48));
  const GrayImage left = image_of(same_column), right = image_of(left_of_right);
  const int all = with_depth(stereo.depth(left.view(), right.view()));
  EXPECT_GT(all, columns * rows / 2);
  EXPECT_EQ(with_depth(stereo.depth(image_of(same_column, 0.0).view(), image_of(left_of_right, 0.0).view())), 0);
  const GrayImage other = image_of([](double x) { return 5000.0 + x; });
  EXPECT_LT(with_depth(stereo.depth(left.view(), other.view())), all / 20);
}

TEST(StereoDepth, DisparitiesOutOfRangeGiveNoDepth) {
  const GrayImage left = image_of(same_column), right = image_of(left_of_right);
  const auto farthest_m = [&](double least_px, int most_px) {
    const DepthImage depth = StereoDepth(options_of(least_px, most_px)).depth(left.view(), right.view());
    double farthest = 0.0;
    for (int y = 0; y < rows; ++y)
      farthest = std::max(farthest, static_cast<double>(*std::max_element(depth.row(y), depth.row(y) + columns)));
    return farthest;
  };
  EXPECT_GT(farthest_m(2.0, 48), 1.9);
  EXPECT_LE(farthest_m(30.0, 48), focal_px * baseline / 30.0 + 1e-6);
  EXPECT_LT(with_depth(StereoDepth(options_of(2.0, 16)).depth(left.view(), right.view())), columns * rows / 6)
      << "nearer than what is searched: at most chance";
}

TEST(StereoDepth, ImagesThatDoNotFitTogetherOrAreTooSmallHaveNone) {
  const StereoDepth stereo(options_of(2.0, 48));
  const GrayImage image = image_of(same_column), small(40, 30);
  EXPECT_TRUE(stereo.depth(image.view(), small.view()).empty());
  const DepthImage none = stereo.depth(small.view(), small.view());
  EXPECT_EQ(none.width(), 40);
  EXPECT_EQ(with_depth(none), 0);
}

}  // namespace
}  // namespace rastro
