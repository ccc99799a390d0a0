// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/planar.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

TEST(Planar, PosesAndCovariancesGoToSpaceAndBack) {
  for (const double yaw : {-3.1, -0.4, 0.0, 2.0}) {
    const SE2 pose(SO2::from_angle(yaw), {3.0, -2.0});
    EXPECT_LT((in_plane(in_space(pose)).matrix() - pose.matrix()).norm(), 1e-14);
    const Eigen::Vector2d moved = pose * Eigen::Vector2d(1.0, 2.0);
    EXPECT_LT((in_space(pose) * Eigen::Vector3d(1.0, 2.0, 0.5) - Eigen::Vector3d(moved.x(), moved.y(), 0.5)).norm(),
              1e-14);
  }
  Eigen::Matrix3d covariance;
  covariance << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0;  // not symmetric: each entry has its position
  EXPECT_EQ(in_plane(in_space(covariance)), covariance);
  Matrix6d full = in_space(covariance);
  for (const int out : {2, 3, 4}) full.row(out).setConstant(7.0);
  EXPECT_EQ(in_plane(full), covariance);
}

TEST(Planar, InformationOfAConstraintIsInTheAxesOfItsEnd) {
  const SE2 relative(SO2::from_angle(0.7), {2.0, 1.0});
  Eigen::Matrix3d information;
  information << 50.0, 5.0, 1.0, 5.0, 20.0, -2.0, 1.0, -2.0, 90.0;
  const Constraint constraint = planar_constraint(3, 8, relative, information, ConstraintKind::merge);
  EXPECT_EQ(constraint.from, 3);
  EXPECT_EQ(constraint.to, 8);
  EXPECT_EQ(constraint.kind, ConstraintKind::merge);
  // (x, y, yaw) in the frame of `from`, small.
  const Eigen::Vector3d off(1e-4, -2e-4, 3e-4);
  const SE2 moved(relative.rotation() * SO2::from_angle(off.z()), relative.translation() + off.head<2>());
  const Vector6d rest = (constraint.rigid().inverse() * in_space(moved)).log();
  EXPECT_NEAR(rest.dot(constraint.information * rest), off.dot(information * off), 1e-8);
}

}  // namespace
}  // namespace rastro
