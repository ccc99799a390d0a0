// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/surface_spread.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

/// 1 on the left, 0.5 from column 8 on.
InverseDepthMap step_at_column_8(float variance) {
  InverseDepthMap map(16, 12);
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 16; ++x) map.mean.at(x, y) = x < 8 ? 1.0F : 0.5F, map.variance.at(x, y) = variance;
  return map;
}

TEST(SurfaceSpread, IsTheDistanceToAnotherSurfaceWithinSixPixels) {
  const InverseDepthMap map = step_at_column_8(1e-4F);
  // Of 24 neighbors, without the one below the image, and the pixel itself, three of each distance lie beyond the step.
  EXPECT_NEAR(surface_spread(map, 7, 6), 0.25 * 9.0 / 24.0, 1e-6);
  EXPECT_NEAR(surface_spread(map, 6, 6), 0.25 * 7.0 / 24.0, 1e-6);
  EXPECT_NEAR(surface_spread(map, 5, 6), 0.25 * 6.0 / 23.0, 1e-6);
  EXPECT_EQ(surface_spread(map, 15, 6), 0.0F);
}

TEST(SurfaceSpread, IsNothingWhereTheVariancesExplainTheDistance) {
  EXPECT_EQ(surface_spread(step_at_column_8(0.1F), 7, 6), 0.0F);
}

TEST(SurfaceSpread, UnknownNeighborsAndTheBorderDoNotCount) {
  InverseDepthMap map = step_at_column_8(1e-4F);
  for (int y = 0; y < 12; ++y) map.variance.at(9, y) = 0.0F;
  EXPECT_NEAR(surface_spread(map, 7, 6), 0.25 * 8.0 / 23.0, 1e-6);
  EXPECT_EQ(surface_spread(map, 0, 0), 0.0F);
}

}  // namespace
}  // namespace rastro
