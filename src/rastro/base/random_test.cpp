// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace rastro {
namespace {

// The published sequence of SplitMix64 for this seed (Vigna's splitmix64.c); a change here would change every result.
TEST(Random, DrawsThePublishedSequence) {
  Random random(1234567);
  for (const std::uint64_t expected : {6457827717110365317ULL, 3203168211198807973ULL, 9817491932198370423ULL,
                                       4593380528125082431ULL, 16408922859458223821ULL}) {
    EXPECT_EQ(random.next(), expected);
  }
}

TEST(Random, UniformStaysInsideAndFillsItsRange) {
  Random random(1);
  double sum = 0.0;
  constexpr int draws = 100'000;
  for (int i = 0; i < draws; ++i) {
    const double value = random.uniform(-2.0, 4.0);
    ASSERT_GE(value, -2.0);
    ASSERT_LT(value, 4.0);
    sum += value;
  }
  // Five standard deviations of the mean: 5 * (6 / sqrt(12)) / sqrt(draws).
  EXPECT_NEAR(sum / draws, 1.0, 0.0274);
}

TEST(Random, BelowReachesEveryValueAboutEquallyOften) {
  Random random(2);
  std::array<int, 7> counts{};
  for (int i = 0; i < 70'000; ++i) ++counts.at(random.below(7));
  for (const int count : counts) EXPECT_NEAR(count, 10'000, 500);
  EXPECT_EQ(random.below(1), 0U);
}

TEST(Random, NormalHasMeanZeroAndDeviationOne) {
  Random random(3);
  constexpr int draws = 100'000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < draws; ++i) {
    const double value = random.normal();
    ASSERT_TRUE(std::isfinite(value));
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / draws, 0.0, 0.016);
  EXPECT_NEAR(squares / draws, 1.0, 0.023);
}

TEST(SeedFor, NeighboringItemsAndSeedsDiffer) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    for (std::uint64_t item = 0; item < 100; ++item) seeds.insert(seed_for(seed, item));
  }
  EXPECT_EQ(seeds.size(), 10'000U);
}

}  // namespace
}  // namespace rastro
