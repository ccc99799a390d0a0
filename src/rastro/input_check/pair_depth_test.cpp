// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/pair_depth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/synthetic/worlds/loop.h"
#include "rastro/track/klt.h"

namespace rastro {
namespace {

struct SeenPair {
  SourceInfo info;
  Frame frame;
};

const SeenPair& seen_pair() {
  static const SeenPair seen = [] {
    const World world = make_loop({.scale = 0.75});
    const auto source = synthetic_source(world, 1, 2, true);
    return SeenPair{source->info(), *source->next()};
  }();
  return seen;
}

std::vector<Eigen::Vector2f> grid() {
  std::vector<Eigen::Vector2f> pixels;
  for (int y = 20; y < seen_pair().frame.image.height() - 20; y += 8)
    for (int x = 60; x < seen_pair().frame.image.width() - 20; x += 8)
      pixels.emplace_back(static_cast<float>(x), static_cast<float>(y));
  return pixels;
}

std::vector<float> depths_with(const GrayImage& right) {
  Pyramid left;
  left.build(seen_pair().frame.image, 4, klt_padding);
  return PairDepth::of(seen_pair().info)->depths(left, right, grid());
}

TEST(PairDepth, MeasuresTheDepthOfTheWorld) {
  const std::vector<Eigen::Vector2f> pixels = grid();
  const std::vector<float> depths = depths_with(seen_pair().frame.right);
  const double growth = PairDepth::of(seen_pair().info)->error_growth();
  int measured = 0, right = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const float truth = seen_pair().frame.depth.at(static_cast<int>(pixels[i].x()), static_cast<int>(pixels[i].y()));
    if (depths[i] == 0.0F || truth == 0.0F) continue;
    ++measured;
    const auto z = static_cast<double>(truth);
    right += std::abs(static_cast<double>(depths[i]) - z) < 3.0 * z * (0.004 + growth * z) ? 1 : 0;
  }
  EXPECT_GT(measured, 100);
  EXPECT_GT(right, 0.8 * measured);
}

TEST(PairDepth, MeasuresNothingWithoutARightImageOfTheSize) {
  for (const GrayImage& right : {GrayImage(), GrayImage(31, 7)})
    for (const float depth : depths_with(right)) EXPECT_EQ(depth, 0.0F);
}

TEST(PairDepth, NeedsACalibratedPair) {
  SourceInfo info = seen_pair().info;
  info.left_from_right.reset();
  EXPECT_FALSE(PairDepth::of(info));
  EXPECT_FALSE(PairDepth::of({}));
}

}  // namespace
}  // namespace rastro
