// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/calibration_error.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

TEST(CalibrationError, GrowsWithTheDistanceAndTheRotationFromTheStart) {
  const Matrix6d covariance = 1e-6 * (Matrix6d::Identity() + 0.5 * Matrix6d::Ones());
  EXPECT_EQ(with_calibration_error(covariance, SE3(), 0.01), covariance);
  EXPECT_EQ(with_calibration_error(covariance, SE3(SO3::exp({0.0, 1.0, 0.0}), {3.0, 0.0, 4.0}), 0.0), covariance);
  const Matrix6d added =
      with_calibration_error(covariance, SE3(SO3::exp({0.0, 0.5, 0.0}), {3.0, 0.0, 4.0}), 0.01) - covariance;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(added(k, k), 0.05 * 0.05, 1e-12);
    EXPECT_NEAR(added(k + 3, k + 3), 0.005 * 0.005, 1e-12);
  }
  EXPECT_EQ(added(0, 1), 0.0);
}

}  // namespace
}  // namespace rastro
