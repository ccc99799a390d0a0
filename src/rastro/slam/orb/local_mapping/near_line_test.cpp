// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/near_line.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/base/simd.h"

namespace rastro {
namespace {

struct Places {
  std::vector<float> x, y, limit;
};

Places random_places(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  Places places;
  for (std::size_t i = 0; i < count; ++i) {
    places.x.push_back(static_cast<float>(random.uniform(-1.0, 1.0)));
    places.y.push_back(static_cast<float>(random.uniform(-1.0, 1.0)));
    places.limit.push_back(static_cast<float>(random.uniform(0.0, 0.1)));
  }
  return places;
}

std::vector<std::uint32_t> near(const Places& places, double angle, float c) {
  std::vector<std::uint32_t> found;
  find_near_line(places.x, places.y, places.limit, static_cast<float>(std::cos(angle)),
                 static_cast<float>(std::sin(angle)), c, found);
  return found;
}

TEST(NearLine, IsTheSameForAnyInstructionSetAndCount) {
  for (std::size_t count = 0; count < 70; ++count) {
    const Places places = random_places(count, count + 1);
    const std::vector<std::uint32_t> fast = near(places, 0.1 * static_cast<double>(count), 0.1F);
    limit_simd_level(SimdLevel::plain);
    const std::vector<std::uint32_t> plain = near(places, 0.1 * static_cast<double>(count), 0.1F);
    limit_simd_level(SimdLevel::avx2);
    EXPECT_EQ(fast, plain) << count << " places";
  }
}

TEST(NearLine, EqualsTheDistanceInDoublePrecision) {
  const Places places = random_places(1000, 7);
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < places.x.size(); ++i) {
    const double distance = 0.6 * static_cast<double>(places.x[i]) + 0.8 * static_cast<double>(places.y[i]) - 0.2;
    if (distance * distance < static_cast<double>(places.limit[i])) expected.push_back(i);
  }
  std::vector<std::uint32_t> found;
  find_near_line(places.x, places.y, places.limit, 0.6F, 0.8F, -0.2F, found);
  ASSERT_GT(expected.size(), 100U);
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace rastro
