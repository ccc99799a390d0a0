// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/packed_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// A slanted wall with steps, noise and holes; every difference between two depths occurs.
DepthImage some_depth(std::uint64_t seed, int width = 61, int height = 37) {
  Random random(seed);
  DepthImage depth(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double kind = random.uniform(0.0, 1.0);
      const double wall = 1.0 + 0.02 * x + (y > height / 2 ? 6.0 : 0.0) + random.uniform(-0.002, 0.002);
      depth.at(x, y) = static_cast<float>(kind < 0.1 ? 0.0 : kind < 0.2 ? random.uniform(0.0, 13.1) : wall);
    }
  return depth;
}

void expect_equal(const DepthImage& a, const DepthImage& b) {
  ASSERT_EQ(a.width(), b.width());
  ASSERT_EQ(a.height(), b.height());
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) ASSERT_EQ(a.at(x, y), b.at(x, y)) << x << ' ' << y;
}

TEST(PackedDepth, NothingIsLostButTheRounding) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const DepthImage depth = some_depth(seed);
    const auto back = unpack_depth(pack_depth(depth));
    ASSERT_TRUE(back);
    expect_equal(*back, rounded_as_packed(depth));
    for (int y = 0; y < depth.height(); ++y)
      for (int x = 0; x < depth.width(); ++x) EXPECT_NEAR(back->at(x, y), depth.at(x, y), 1.01e-4F);
  }
}

/// std::round, as maps before version 4 had it.
TEST(PackedDepth, RoundsToTheNearestUnitAndLeavesOutWhatDoesNotFit) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  DepthImage depth(400, 1);
  const float special[] = {0.0F, -1.0F, 13.2F, 1e9F, infinity, -infinity, std::nanf(""), 5e-5F, 13.107F, 13.1071F};
  std::copy(std::begin(special), std::end(special), depth.row(0));
  for (int x = 10; x < 400; ++x) depth.at(x, 0) = static_cast<float>(x) * 0.0331F + 1e-4F;
  const DepthImage rounded = rounded_as_packed(depth);
  for (int x = 0; x < 400; ++x) {
    const double units = std::round(static_cast<double>(depth.at(x, 0)) * packed_depth_units_per_meter);
    const bool fits = units > 0.0 && units <= 65535.0;
    EXPECT_EQ(rounded.at(x, 0), fits ? static_cast<float>(units / packed_depth_units_per_meter) : 0.0F) << x;
  }
}

TEST(PackedDepth, ReadsThePngImagesOfOlderMaps) {
  cv::Mat units(3, 4, CV_16U);
  for (int k = 0; k < 12; ++k) units.at<std::uint16_t>(k / 4, k % 4) = static_cast<std::uint16_t>(5900 * k);
  std::vector<std::uint8_t> png;
  cv::imencode(".png", units, png);
  const auto depth = unpack_depth(png);
  ASSERT_TRUE(depth);
  for (int k = 0; k < 12; ++k) EXPECT_FLOAT_EQ(depth->at(k % 4, k / 4), 1.18F * static_cast<float>(k));
  cv::Mat bytes(3, 4, CV_8U, cv::Scalar(7));
  cv::imencode(".png", bytes, png);
  EXPECT_FALSE(unpack_depth(png)) << "8 bits are no depth";
}

TEST(PackedDepth, EmptyAndBlankImages) {
  EXPECT_TRUE(pack_depth({}).empty());
  EXPECT_FALSE(unpack_depth({}));
  const auto blank = unpack_depth(pack_depth(DepthImage(5, 4)));
  ASSERT_TRUE(blank);
  expect_equal(*blank, DepthImage(5, 4));
}

TEST(PackedDepth, DamagedBytesAreRefusedOrAnImage) {
  const std::vector<std::uint8_t> good = pack_depth(some_depth(3));
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(unpack_depth(std::span(good).first(length))) << length;
  Random random(5);
  for (int trial = 0; trial < 3000; ++trial) {
    std::vector<std::uint8_t> bytes = good;
    for (std::uint32_t k = random.below(3) + 1; k > 0; --k)
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] = static_cast<std::uint8_t>(random.below(256));
    const auto depth = unpack_depth(bytes);
    EXPECT_TRUE(!depth || depth->width() * depth->height() == 61 * 37) << trial;
  }
}

TEST(PackedDepth, AHeaderThatClaimsTooMuchTakesNoMemory) {
  std::vector<std::uint8_t> bytes = pack_depth(some_depth(3));
  for (std::size_t k = 4; k < 12; ++k) bytes[k] = 0xFF;
  EXPECT_FALSE(unpack_depth(bytes));
  bytes[6] = bytes[7] = bytes[10] = bytes[11] = 0;  // 65535 x 65535
  EXPECT_FALSE(unpack_depth(bytes));
}

}  // namespace
}  // namespace rastro
