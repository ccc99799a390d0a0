// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/map_uncertainty.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/random.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::matrix_near;

Matrix6d diagonal(double sigma_m, double sigma_rad) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(sigma_m * sigma_m), Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return variances.asDiagonal();
}

TEST(MapUncertainty, APoseHasTheErrorsOfThePartItWasTrackedAgainstAndItsOwn) {
  MapUncertainty uncertainty;
  const Eigen::Vector3d at(1.0, 2.0, 0.5);
  EXPECT_EQ(uncertainty.of_pose(0, at, diagonal(0.01, 0.001)), diagonal(0.01, 0.001)) << "the first part is certain";
  uncertainty.set(1, at, diagonal(0.03, 0.0));
  const Matrix6d pose = uncertainty.of_pose(1, at, diagonal(0.04, 0.002));
  EXPECT_THAT(pose, matrix_near(diagonal(0.05, 0.002), 1e-15));
  uncertainty.set(2, at, pose);
  EXPECT_NEAR(uncertainty.of_pose(2, at, diagonal(0.12, 0.0))(0, 0), 0.13 * 0.13, 1e-12) << "along a chain";
  EXPECT_NEAR(uncertainty.of_pose(0, at, diagonal(0.01, 0.0))(0, 0), 0.01 * 0.01, 1e-15) << "back at the first";
}

/// Against poses that are drawn.
TEST(MapUncertainty, ARotationOfAPartMovesWhatIsFarFromIt) {
  const Eigen::Vector3d part(1.0, -2.0, 0.5), pose(9.0, 3.0, -1.5);
  const Matrix6d of_part = diagonal(0.02, 0.01);
  MapUncertainty uncertainty;
  uncertainty.set(4, part, of_part);
  Random random(3);
  Matrix6d drawn = Matrix6d::Zero();
  constexpr int draws = 20000;
  for (int i = 0; i < draws; ++i) {
    Vector6d error;
    for (int k = 0; k < 6; ++k) error(k) = (k < 3 ? 0.02 : 0.01) * random.normal();
    const SO3 rotation = SO3::exp(error.tail<3>());
    Vector6d moved;
    moved << part + error.head<3>() + rotation * Eigen::Vector3d(pose - part) - pose, error.tail<3>();
    drawn += moved * moved.transpose() / draws;
  }
  const Matrix6d covariance = uncertainty.of_pose(4, pose, Matrix6d::Zero());
  EXPECT_THAT(covariance, matrix_near(drawn, 0.03 * drawn.norm()));
  EXPECT_GT(covariance(2, 2), 0.07 * 0.07);
}

TEST(MapUncertainty, ALoopClosureOnlyReducesWhatIsKnownToBeUncertain) {
  MapUncertainty uncertainty;
  const Eigen::Vector3d at = Eigen::Vector3d::Zero();
  uncertainty.reduce(1, at, diagonal(0.5, 0.1));
  EXPECT_EQ(uncertainty.of_pose(1, at, Matrix6d::Zero()).trace(), 0.0) << "it was certain";
  uncertainty.set(1, at, diagonal(0.2, 0.02));
  uncertainty.reduce(1, at, diagonal(0.3, 0.02));
  EXPECT_NEAR(uncertainty.of_pose(1, at, Matrix6d::Zero())(0, 0), 0.04, 1e-12);
  uncertainty.reduce(1, at, diagonal(0.1, 0.02));
  EXPECT_NEAR(uncertainty.of_pose(1, at, Matrix6d::Zero())(0, 0), 0.01, 1e-12);
  uncertainty.set(1, at, diagonal(0.4, 0.02));
  EXPECT_NEAR(uncertainty.of_pose(1, at, Matrix6d::Zero())(0, 0), 0.16, 1e-12) << "set() may also raise it";
}

}  // namespace
}  // namespace rastro
