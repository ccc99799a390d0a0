// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/sensed_depths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Inverse depths of 0.1 to 0.5 / m, sensed with this relative error, in a map that has them too large by 0.3 %.
std::vector<DepthRatio> ratios(int count, double relative_sigma, double share_in_front) {
  Random random(4);
  std::vector<DepthRatio> all;
  for (int i = 0; i < count; ++i) {
    const double exact = random.uniform(0.1, 0.5);
    double sensed = exact * (1.0 + relative_sigma * random.normal());
    if (random.uniform(0.0, 1.0) < share_in_front) sensed = exact * random.uniform(1.0, 1.5);
    // The sigma is thought to be four times larger.
    all.push_back({sensed, 4.0 * relative_sigma * exact, 1.003 * exact});
  }
  return all;
}

TEST(SensedScale, IsThatOfTheMapWithoutTheEdgesOfNearerThings) {
  EXPECT_NEAR(sensed_scale(ratios(20000, 0.01, 0.0)), 1.0 / 1.003, 0.0003);
  EXPECT_NEAR(sensed_scale(ratios(20000, 0.01, 0.15)), 1.0 / 1.003, 0.001) << "their mean is 3.7 % off";
}

TEST(SensedScale, IsOneWhereFewWereSensed) {
  EXPECT_EQ(sensed_scale({}), 1.0);
  EXPECT_EQ(sensed_scale(ratios(499, 0.01, 0.0)), 1.0);
  EXPECT_NE(sensed_scale(ratios(500, 0.01, 0.0)), 1.0);
}

TEST(SensedDepthMap, GivesThePixelWithTheLargestGradientOfEachCellThatWasMatched) {
  GrayImage image(40, 24);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 40; ++x) image.at(x, y) = static_cast<std::uint8_t>(x * x / 8);
  EpipolarQueries queries;
  EpipolarMatches matches;
  for (const int x : {9, 11, 13, 20}) {
    const auto i = static_cast<std::size_t>(queries.count);
    add_query(x, 10, {0.0, 0.5, 1.0}, queries);
    matches.result[i] = static_cast<std::int32_t>(x == 13 ? EpipolarResult::ambiguous : EpipolarResult::matched);
    matches.mean[i] = 0.01F * static_cast<float>(x), matches.variance[i] = 0.0004F;
  }
  SensedDepthMap sensed(40, 24);
  sensed.note(queries, matches);
  const std::vector<SensedDepth> chosen = sensed.thinned(image.view(), 8);  // cells from 4 to 11, 12 to 19, 20 to 27
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0].x, 11);
  EXPECT_EQ(chosen[0].y, 10);
  EXPECT_FLOAT_EQ(chosen[0].inverse_depth, 0.11F);
  EXPECT_FLOAT_EQ(chosen[0].sigma, 0.02F);
  EXPECT_EQ(chosen[1].x, 20);
}

/// Else pixels chosen in the halves would not be those chosen in the cells.
TEST(CellFor, HalvesOfACellFillIt) {
  for (const int points : {1, 50, 800, 801, 2000, 100000}) {
    for (const int width : {64, 640, 752, 1241}) {
      const int cell = cell_for(points, width, 480);
      EXPECT_GE(cell, 2);
      EXPECT_EQ(cell % 2, 0) << points << ' ' << width;
    }
  }
  EXPECT_EQ(cell_for(800, 640, 480), 18) << "19.6";
}

}  // namespace
}  // namespace rastro
