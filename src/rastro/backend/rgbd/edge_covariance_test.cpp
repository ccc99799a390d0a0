// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/edge_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace rastro {
namespace {

TEST(EdgeCovariance, CommonErrorsAreAddedAndTakenAway) {
  const RgbdSlamOptions options;
  const Matrix6d noise = 1e-6 * (Matrix6d::Identity() + 0.2 * Matrix6d::Ones());
  const Matrix6d sum = with_common_errors(noise, options);
  EXPECT_DOUBLE_EQ(sum(0, 0), noise(0, 0) + options.edge_sigma_m * options.edge_sigma_m);
  EXPECT_DOUBLE_EQ(sum(5, 5), noise(5, 5) + options.edge_sigma_rad * options.edge_sigma_rad);
  EXPECT_DOUBLE_EQ(sum(0, 5), noise(0, 5));
  Constraint edge;
  edge.information = sum.inverse();
  EXPECT_LT((without_common_errors(edge, options) - noise).norm(), 1e-6 * noise.norm());
}

TEST(EdgeCovariance, AnEdgeThatCameWithoutThemKeepsAVariance) {
  Constraint edge;
  edge.information = 1e10 * Matrix6d::Identity();
  const Matrix6d covariance = without_common_errors(edge, RgbdSlamOptions());
  EXPECT_NEAR(covariance(0, 0), 1e-12, 1e-18);
  EXPECT_NEAR(covariance(5, 5), 1e-12, 1e-18);
}

}  // namespace
}  // namespace rastro
