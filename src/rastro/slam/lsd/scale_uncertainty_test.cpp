// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/scale_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "rastro/base/random.h"

namespace rastro {
namespace {

TEST(ScaleUncertainty, GrowsTowardTheEndsOfAWalk) {
  const std::vector<double> variances = scale_variances(3, {{0, 1, 9.0}, {1, 2, 9.0}});
  EXPECT_NEAR(variances[0], 5.0, 1e-9);
  EXPECT_NEAR(variances[1], 2.0, 1e-9);
  EXPECT_NEAR(variances[2], 5.0, 1e-9);
}

TEST(ScaleUncertainty, IsTheSameAllAroundAClosedLoop) {
  for (const double variance : scale_variances(4, {{0, 1, 1.0}, {1, 2, 1.0}, {2, 3, 1.0}, {3, 0, 1.0}}))
    EXPECT_NEAR(variance, 15.0 / 48.0, 1e-12);
}

TEST(ScaleUncertainty, OfSubmapsIsEachForItself) {
  const std::vector<double> variances = scale_variances(5, {{0, 3, 4.0}, {1, 4, 8.0}});
  for (const std::size_t k : {0U, 3U}) EXPECT_NEAR(variances[k], 1.0, 1e-12) << k;
  for (const std::size_t k : {1U, 4U}) EXPECT_NEAR(variances[k], 2.0, 1e-12) << k;
  EXPECT_EQ(variances[2], 0.0);
  EXPECT_TRUE(scale_variances(0, {}).empty());
}

/// The information about all scales leaves the mean open.
TEST(ScaleUncertainty, IsThatOfThePseudoinverse) {
  constexpr std::size_t count = 30;
  Random random(3);
  std::vector<ScaleLink> links;
  for (std::size_t k = 1; k < count; ++k) links.push_back({k - 1, k, random.uniform(0.1, 1.0)});
  for (int i = 0; i < 10; ++i) {
    const auto a = static_cast<std::size_t>(random.uniform(0.0, 10.0)),
               b = static_cast<std::size_t>(random.uniform(15.0, 30.0));
    links.push_back({a, b, random.uniform(0.5, 5.0)});
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(count, count);
  for (const ScaleLink& link : links) {
    Eigen::VectorXd by = Eigen::VectorXd::Zero(count);
    by[static_cast<Eigen::Index>(link.a)] = 1.0, by[static_cast<Eigen::Index>(link.b)] = -1.0;
    information += by * by.transpose() / link.variance;
  }
  const Eigen::MatrixXd mean = Eigen::MatrixXd::Constant(count, count, 1.0 / count);
  const Eigen::MatrixXd covariance = (information + mean).inverse() - mean;
  const std::vector<double> variances = scale_variances(count, links);
  for (std::size_t k = 0; k < count; ++k)
    EXPECT_NEAR(variances[k], covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)), 1e-9) << k;
}

}  // namespace
}  // namespace rastro
