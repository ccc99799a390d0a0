// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/thin_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "rastro/base/random.h"

namespace rastro {
namespace {

std::vector<float> square(std::size_t count) {
  Random random(5);
  std::vector<float> positions;
  for (std::size_t k = 0; k < count; ++k)
    for (const double high : {10.0, 10.0, 0.0})
      positions.push_back(static_cast<float>(random.uniform(0.0, 1.0) * high));
  return positions;
}

TEST(ThinPoints, KeepsAllWhereTheyAreFew) {
  EXPECT_EQ(thin_points(square(3), 0.0, 3), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_TRUE(thin_points({}, 0.0, 1).empty());
  EXPECT_TRUE(thin_points({}, 0.1, 1).empty());
}

TEST(ThinPoints, SpreadsThoseThatStay) {
  const auto positions = square(20'000);
  const auto kept = thin_points(positions, 0.0, 1'000);
  EXPECT_LE(kept.size(), 1'000U);
  EXPECT_GE(kept.size(), 500U) << "it must not take away much more than asked for";
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  std::set<std::pair<int, int>> squares;  // of 1 m side: each of the hundred has some
  for (const auto k : kept) squares.emplace(static_cast<int>(positions[3 * k]), static_cast<int>(positions[3 * k + 1]));
  EXPECT_EQ(squares.size(), 100U);
}

TEST(ThinPoints, KeepsOneOfEachCube) {
  const std::vector<float> positions = {0.0F, 0.0F, 0.0F, 0.04F, 0.0F, 0.0F, 0.0F, 0.0F, 0.06F, 0.01F, 0.0F, 0.07F};
  EXPECT_EQ(thin_points(positions, 0.05, 100), (std::vector<std::uint32_t>{0, 2}));
}

TEST(ThinPoints, LeavesOutWhatIsNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::vector<float> positions = {nan, 0.0F, 0.0F, 1.0F, 1.0F, 1.0F, 0.0F, inf, 0.0F};
  EXPECT_EQ(thin_points(positions, 0.1, 5), std::vector<std::uint32_t>{1});
}

TEST(ThinPoints, EndsForPointsThatCannotBeSeparated) {
  const std::vector<float> same(3 * 50, 2.0F);
  EXPECT_EQ(thin_points(same, 0.0, 10), std::vector<std::uint32_t>{0});
  std::vector<float> far = square(50);
  far[0] = 3e38F, far[3] = -3e38F;
  EXPECT_LE(thin_points(far, 0.0, 10).size(), 10U);
}

}  // namespace
}  // namespace rastro
