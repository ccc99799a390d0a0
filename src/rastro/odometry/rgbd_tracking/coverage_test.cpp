// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/coverage.h"

#include <gtest/gtest.h>

#include <numeric>

namespace rastro {
namespace {

Camera vga() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  return camera;
}

FoundPoint at(float x, float y) { return {0, {x, y}, {}, true}; }

/// Hundred features in one part of the image, two in each of four others.
std::vector<FoundPoint> crowded() {
  std::vector<FoundPoint> found;
  for (int i = 0; i < 100; ++i)
    found.push_back(at(330.0F + static_cast<float>(i % 10), 250.0F + static_cast<float>(i / 10)));
  for (const float x : {10.0F, 600.0F})
    for (const float y : {10.0F, 470.0F}) found.insert(found.end(), 2, at(x, y));
  return found;
}

TEST(CoverageWeights, ACrowdedPartOfTheImageCountsLessThanFourOthers) {
  const auto weights = coverage_weights(crowded(), vga());
  const int crowd = std::accumulate(weights.begin(), weights.begin() + 100, 0);
  const int others = std::accumulate(weights.begin() + 100, weights.end(), 0);
  EXPECT_LT(crowd, others);
  EXPECT_GT(3 * crowd, others) << "two features of a part count less than hundred";
  EXPECT_TRUE(coverage_weights({}, vga()).empty());
}

TEST(CoverageWeights, FeaturesOutsideTheImageCountForItsEdge) {
  const std::vector<FoundPoint> outside{at(-5.0F, -5.0F), at(1e9F, 1e9F)};
  EXPECT_EQ(coverage_weights(outside, vga()).size(), 2U);
}

TEST(WeightedShare, IsTheShareOfTheWeights) {
  const std::vector<std::int32_t> weights{10, 30, 60};
  EXPECT_DOUBLE_EQ(weighted_share(weights, std::vector<std::uint8_t>{1, 0, 1}), 0.7);
  EXPECT_EQ(weighted_share({}, {}), 0.0);
}

TEST(MovingParts, AreWhereMostFeaturesDoNotFitAndBeside) {
  std::vector<FoundPoint> found = crowded();
  std::vector<std::uint8_t> fits(found.size(), 0);
  std::fill(fits.begin() + 100, fits.end(), 1);
  const ImageParts moving = moving_parts(found, fits, vga());
  EXPECT_TRUE(moving.any());
  EXPECT_TRUE(moving.at(335, 255));
  EXPECT_TRUE(moving.at(335 - ImageParts::part_px, 255));
  EXPECT_FALSE(moving.at(335 - 3 * ImageParts::part_px, 255));
  EXPECT_FALSE(moving.at(10, 10));
  fits.assign(found.size(), 1);
  fits[0] = 0;
  EXPECT_FALSE(moving_parts(found, fits, vga()).any()) << "one of hundred";
}

}  // namespace
}  // namespace rastro
