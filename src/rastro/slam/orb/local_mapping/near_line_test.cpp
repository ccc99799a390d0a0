// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/near_line.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/base/simd.h"

namespace rastro {
namespace {

struct Points {
  std::vector<float> x, y, limit;
};

Points random_points(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    points.x.push_back(static_cast<float>(random.uniform(-1.0, 1.0)));
    points.y.push_back(static_cast<float>(random.uniform(-1.0, 1.0)));
    points.limit.push_back(static_cast<float>(random.uniform(0.0, 0.1)));
  }
  return points;
}

std::vector<std::uint32_t> near(const Points& points, double angle, float c) {
  std::vector<std::uint32_t> found;
  find_near_line(points.x, points.y, points.limit, static_cast<float>(std::cos(angle)),
                 static_cast<float>(std::sin(angle)), c, found);
  return found;
}

TEST(NearLine, IsTheSameForAnyInstructionSetAndCount) {
  for (std::size_t count = 0; count < 70; ++count) {
    const Points points = random_points(count, count + 1);
    const std::vector<std::uint32_t> fast = near(points, 0.1 * static_cast<double>(count), 0.1F);
    limit_simd_level(SimdLevel::plain);
    const std::vector<std::uint32_t> plain = near(points, 0.1 * static_cast<double>(count), 0.1F);
    limit_simd_level(SimdLevel::avx2);
    EXPECT_EQ(fast, plain) << count << " points";
  }
}

TEST(NearLine, EqualsTheDistanceInDoublePrecision) {
  const Points points = random_points(1000, 7);
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < points.x.size(); ++i) {
    const double distance = 0.6 * static_cast<double>(points.x[i]) + 0.8 * static_cast<double>(points.y[i]) - 0.2;
    if (distance * distance < static_cast<double>(points.limit[i])) expected.push_back(i);
  }
  std::vector<std::uint32_t> found;
  find_near_line(points.x, points.y, points.limit, 0.6F, 0.8F, -0.2F, found);
  ASSERT_GT(expected.size(), 100U);
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace rastro
