// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/switch_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace rastro {
namespace {

TEST(SwitchKernel, CostIsThatOfTheBestSwitch) {
  for (const double price : {1.0, 30.0}) {
    for (const double squared : {0.0, 0.5, 6.0, 40.0, 1e4}) {
      double best = squared;
      for (int k = 0; k <= 10000; ++k) {
        const double open = k / 10000.0;
        best = std::min(best, open * open * squared + price * (1.0 - open) * (1.0 - open));
      }
      EXPECT_NEAR(SwitchKernel{price}.cost(squared), best, 1e-4 * (1.0 + best)) << price << ' ' << squared;
    }
  }
}

TEST(SwitchKernel, WeightAndItsSlopeAreDerivatives) {
  const SwitchKernel kernel{30.0};
  EXPECT_EQ(kernel.weight(0.0), 1.0);
  constexpr double step = 1e-4;
  for (const double squared : {0.5, 6.0, 40.0, 1000.0}) {
    const auto slope = [&](double ahead, double back) { return (ahead - back) / (2.0 * step); };
    EXPECT_NEAR(kernel.weight(squared), slope(kernel.cost(squared + step), kernel.cost(squared - step)), 1e-7);
    const double weight_slope = slope(kernel.weight(squared + step), kernel.weight(squared - step));
    EXPECT_NEAR(kernel.weight_slope(squared), weight_slope, 1e-4 * -weight_slope);
  }
}

TEST(SwitchKernel, SwitchingOffCostsItsPrice) {
  const SwitchKernel kernel{30.0};
  EXPECT_NEAR(kernel.cost(30.0), 15.0, 1e-12);
  EXPECT_LT(kernel.cost(1e9), 30.0);
  EXPECT_NEAR(kernel.cost(1e9), 30.0, 1e-5);
}

}  // namespace
}  // namespace rastro
