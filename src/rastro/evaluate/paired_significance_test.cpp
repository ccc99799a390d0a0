// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/paired_significance.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <numeric>

namespace rastro {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

/// The p-value by trying all signs of the ranks 1 to n (no ties).
double by_all_signs(const std::vector<double>& signed_ranks) {
  const auto n = static_cast<std::uint32_t>(signed_ranks.size());
  double positive = 0.0, as_extreme = 0.0;
  for (const double rank : signed_ranks) positive += std::max(rank, 0.0);
  const double mean = n * (n + 1) / 4.0;
  for (std::uint32_t signs = 0; signs < (1U << n); ++signs) {
    double sum = 0.0;
    for (std::uint32_t k = 0; k < n; ++k) sum += (signs >> k & 1U) != 0 ? k + 1.0 : 0.0;
    if (std::abs(sum - mean) >= std::abs(positive - mean) - 1e-9) as_extreme += 1.0;
  }
  return as_extreme / std::pow(2.0, n);
}

TEST(PairedSignificance, SignedRankIsTheShareOfAllSigns) {
  for (const std::vector<double>& ranks :
       {std::vector<double>{1, -2, 3, 4, 5, -6, 7, 8}, {-1, -2, -3, -4, 5}, {1, 2, -3}, {-1}})
    EXPECT_NEAR(signed_rank_p_value(ranks), by_all_signs(ranks), 1e-12);
}

TEST(PairedSignificance, SignedRankOfTextbookTables) {
  EXPECT_NEAR(signed_rank_p_value({1, 2, 3, 4, 5}), 0.0625, 1e-12);  // the smallest of five
  EXPECT_NEAR(signed_rank_p_value({1, 2, 3, 4, 5, 6}), 0.03125, 1e-12);
  EXPECT_EQ(signed_rank_p_value({}), 1.0);
  EXPECT_EQ(signed_rank_p_value({0.0, 0.0}), 1.0) << "no difference at all";
  EXPECT_EQ(signed_rank_p_value({2.0, -2.0}), 1.0) << "equal sizes share their rank";
}

TEST(PairedSignificance, SignedRankOfManyIsClosesToCounting) {
  std::vector<double> differences;
  for (int k = 1; k <= 60; ++k) differences.push_back(k % 3 == 0 ? -k : k);
  const double counted = signed_rank_p_value(differences);
  differences.push_back(-1e-3);
  EXPECT_NEAR(signed_rank_p_value(differences), counted, 0.1 * counted);
}

TEST(PairedSignificance, HolmMultipliesTheSmallestMost) {
  EXPECT_THAT(holm_adjusted({0.04, 0.01, 0.03}),
              ElementsAre(DoubleNear(0.06, 1e-12), DoubleNear(0.03, 1e-12), DoubleNear(0.06, 1e-12)));
  EXPECT_THAT(holm_adjusted({0.9, 0.8}), ElementsAre(1.0, 1.0));
}

}  // namespace
}  // namespace rastro
