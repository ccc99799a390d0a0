// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/robust_kernel.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

template <typename Kernel>
class RobustKernel : public ::testing::Test {};
using Kernels = ::testing::Types<HuberKernel, CauchyKernel, TukeyKernel>;
TYPED_TEST_SUITE(RobustKernel, Kernels);

TYPED_TEST(RobustKernel, WeightIsTheDerivativeOfCost) {
  const TypeParam kernel{2.0};
  for (const double s : {0.01, 0.5, 1.0, 3.9, 4.1, 10.0, 100.0, 1e4}) {
    const double step = 1e-5 * s;
    EXPECT_NEAR(kernel.weight(s), (kernel.cost(s + step) - kernel.cost(s - step)) / (2.0 * step), 1e-6) << s;
  }
}

TYPED_TEST(RobustKernel, IsLeastSquaresForSmallErrorsAndBelowItForLarge) {
  const TypeParam kernel{2.0};
  EXPECT_EQ(kernel.cost(0.0), 0.0);
  EXPECT_EQ(kernel.weight(0.0), 1.0);
  EXPECT_NEAR(kernel.cost(1e-6), 1e-6, 1e-12);
  double last_cost = 0.0, last_weight = 1.0;
  for (double s = 0.1; s < 1e5; s *= 1.5) {
    EXPECT_GE(kernel.cost(s), last_cost);
    EXPECT_LE(kernel.weight(s), last_weight);
    EXPECT_LE(kernel.cost(s), s);
    last_cost = kernel.cost(s);
    last_weight = kernel.weight(s);
  }
  EXPECT_LT(last_weight, 0.01);
}

TEST(TukeyKernel, IgnoresWhatIsBeyondItsWidth) {
  const TukeyKernel kernel{3.0};
  EXPECT_EQ(kernel.weight(9.0), 0.0);
  EXPECT_EQ(kernel.weight(1e9), 0.0);
  EXPECT_EQ(kernel.cost(1e9), 3.0);
}

}  // namespace
}  // namespace rastro
