// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/median.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "rastro/base/random.h"

namespace rastro {
namespace {

TEST(Median, OfAnOddNumberIsTheMiddleOne) {
  EXPECT_EQ(median({7.0}), 7.0);
  EXPECT_EQ(median({3.0, -1.0, 2.0}), 2.0);
  EXPECT_EQ(upper_median<double>({3.0, -1.0, 2.0}), 2.0);
}

TEST(Median, OfAnEvenNumberIsTheMeanOrTheUpperOfTwo) {
  EXPECT_EQ(median({4.0, 1.0, 9.0, 2.0}), 3.0);
  EXPECT_EQ(upper_median<double>({4.0, 1.0, 9.0, 2.0}), 4.0);
  EXPECT_EQ(upper_median<std::int64_t>({5, 5, 6, 6}), 6);
}

TEST(Median, OfNoValues) {
  EXPECT_EQ(upper_median_or(std::vector<float>{}, 2.5F), 2.5F);
  EXPECT_EQ(upper_median_or(std::vector<float>{1.5F}, 2.5F), 1.5F);
  EXPECT_ANY_THROW(median({}));
  EXPECT_ANY_THROW(upper_median(std::vector<float>{}));
}

TEST(Median, IsThatOfSortedValues) {
  Random random(5);
  for (std::size_t count = 1; count < 40; ++count) {
    std::vector<double> values(count);
    for (double& value : values) value = random.uniform(-1.0, 1.0);
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(upper_median(values), sorted[count / 2]);
    EXPECT_EQ(median(values), 0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]));
  }
}

TEST(WeightedMedian, HasHalfOfTheWeightsOnEitherSide) {
  EXPECT_EQ(weighted_median({{7.0, 0.1}}), 7.0);
  EXPECT_EQ(weighted_median({{3.0, 1.0}, {1.0, 1.0}, {2.0, 1.0}}), 2.0);
  EXPECT_EQ(weighted_median({{4.0, 1.0}, {1.0, 1.0}, {9.0, 1.0}, {2.0, 1.0}}), 3.0) << "as without weights";
  EXPECT_EQ(weighted_median({{3.0, 1.0}, {1.0, 5.0}, {2.0, 1.0}}), 1.0);
  EXPECT_EQ(weighted_median({{1.0, 1.0}, {2.0, 1.0}, {3.0, 0.5}, {9.0, 8.0}}), 9.0);
  EXPECT_ANY_THROW(weighted_median({}));
}

}  // namespace
}  // namespace rastro
