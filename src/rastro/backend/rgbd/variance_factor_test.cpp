// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/variance_factor.h"

#include <gtest/gtest.h>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Relative to what it is before there are residuals.
double after(double squared_sigmas, double redundancy) {
  VarianceFactor factor;
  const double assumed = factor.value();
  factor.add(squared_sigmas, redundancy);
  return factor.value() / assumed;
}

TEST(VarianceFactor, ManyResidualsDecideFewDoNot) {
  EXPECT_NEAR(after(0.04 * 1e6, 1e6), 0.04, 1e-4);
  EXPECT_NEAR(after(9.0 * 1e6, 1e6), 9.0, 1e-2);
  EXPECT_GT(after(0.04 * 6, 6), 0.85);
}

TEST(VarianceFactor, ResidualsOfTheAssumedSizeChangeNothing) {
  Random random(3);
  double squared = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const double residual = random.normal();
    squared += residual * residual;
  }
  EXPECT_NEAR(after(squared, 5000), 1.0, 0.06);
}

TEST(VarianceFactor, WithoutRedundancyResidualsSayNothing) {
  EXPECT_EQ(after(0.0, 0.0), 1.0);
  EXPECT_EQ(after(5.0, -6.0), 1.0);
}

}  // namespace
}  // namespace rastro
