// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/map_uncertainty.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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

/// Both may have the same errors, or opposite ones: of x and y, the better known one is taken from each.
TEST(MapUncertainty, ALoopClosureThatKnowsOneDirectionBetterDoesNotSpoilTheOther) {
  MapUncertainty uncertainty;
  const Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Matrix6d before = Matrix6d::Zero(), by_loop = before;
  before(0, 0) = 0.09, before(1, 1) = 0.0025, before(5, 5) = 1e-5;
  by_loop(0, 0) = 0.0009, by_loop(1, 1) = 0.01, by_loop(5, 5) = 1e-4;
  uncertainty.set(1, at, before);
  uncertainty.reduce(1, at, by_loop);
  const Matrix6d reduced = uncertainty.of_pose(1, at, Matrix6d::Zero());
  EXPECT_LT(reduced(0, 0), 0.003);
  EXPECT_LT(reduced(1, 1), 0.01);
  EXPECT_LT(reduced(5, 5), 1e-4);
  EXPECT_EQ(reduced(2, 2), 0.0) << "a direction without variance stays without";
  // Whatever the mixture of both estimates and the correlation of their errors, none is claimed to be more certain.
  for (int axis = 0; axis < 6; ++axis)
    EXPECT_GE(reduced(axis, axis), std::min(before(axis, axis), by_loop(axis, axis)));
  uncertainty.reduce(1, at, reduced);
  EXPECT_THAT(uncertainty.of_pose(1, at, Matrix6d::Zero()), matrix_near(reduced, 1e-12)) << "the same says nothing new";
}

/// A rotation known a little worse moves what is seen far away: both are compared where the robot is.
TEST(MapUncertainty, ALoopClosureIsComparedWhereItWasClosed) {
  MapUncertainty uncertainty;
  Matrix6d of_part = Matrix6d::Zero(), by_loop = of_part;
  of_part(0, 0) = of_part(1, 1) = 0.0004, of_part(5, 5) = 1e-4;
  by_loop(0, 0) = by_loop(1, 1) = 0.0016, by_loop(5, 5) = 1e-4;
  uncertainty.set(1, Eigen::Vector3d::Zero(), of_part);
  const Eigen::Vector3d far(20.0, 0.0, 0.0);
  uncertainty.reduce(1, far, by_loop);
  EXPECT_LT(uncertainty.of_pose(1, far, Matrix6d::Zero())(1, 1), 0.005) << "0.0404 by the part alone";
}

TEST(MapUncertainty, WhatMovesBeyondItsErrorsIsAsUncertainAsItMoved) {
  const Eigen::Vector3d at(1.0, 2.0, 0.0);
  const SE3 before(SO3::exp({0.0, 0.0, 0.3}), at);
  MapUncertainty uncertainty;
  uncertainty.set(1, at, diagonal(0.01, 0.005));
  uncertainty.contradict(1, before, SE3(before.rotation(), at + Eigen::Vector3d(0.04, 0.0, 0.0)));
  EXPECT_NEAR(uncertainty.of_pose(1, at, Matrix6d::Zero())(0, 0), 1e-4, 1e-12) << "4 sigmas in one of six directions";
  const SE3 turned(SO3::exp({0.0, 0.0, 0.1}) * before.rotation(), at + Eigen::Vector3d(0.2, 0.0, 0.0));
  uncertainty.contradict(1, before, turned);
  const Matrix6d covariance = uncertainty.of_pose(1, at, Matrix6d::Zero());
  constexpr double share = 1.0 - 16.81 / (400.0 + 400.0);
  EXPECT_NEAR(covariance(0, 0), 1e-4 + share * 0.04, 1e-9);
  EXPECT_NEAR(covariance(5, 5), 2.5e-5 + share * 0.01, 1e-9) << "in the world's axes";
  EXPECT_NEAR(covariance(0, 5), share * 0.02, 1e-9) << "both of one cause";
  EXPECT_NEAR(covariance(1, 1), 1e-4, 1e-12);
  uncertainty.contradict(2, before, turned);
  EXPECT_FALSE(uncertainty.contains(2)) << "the origin, or not a part";
}

TEST(MapUncertainty, WhatWasCertainAndMovesIsAsUncertainAsItMoved) {
  const Eigen::Vector3d at(1.0, 2.0, 0.0), step(0.1, 0.0, -0.2);
  const SE3 before(SO3::exp({0.0, 0.0, 0.3}), at), after(before.rotation(), at + step);
  const SE3 rounded(before.rotation(), at + Eigen::Vector3d(0.0, 1e-14, 0.0));
  for (const double sigma_rad : {0.0, 0.001, 1e-160}) {
    MapUncertainty uncertainty;
    uncertainty.set(1, at, diagonal(0.0, sigma_rad));
    uncertainty.contradict(1, before, before);
    uncertainty.contradict(1, before, rounded);
    EXPECT_EQ(uncertainty.of_pose(1, at, Matrix6d::Zero()), diagonal(0.0, sigma_rad)) << "it did not move";
    uncertainty.contradict(1, before, after);
    const Eigen::Matrix3d position = uncertainty.of_pose(1, at, Matrix6d::Zero()).topLeftCorner<3, 3>();
    EXPECT_THAT(position, matrix_near(Eigen::Matrix3d(step * step.transpose()), 1e-9)) << sigma_rad;
  }
}

/// Of one camera a wrong scale moves what is far away from where it became wrong, and along that direction alone.
TEST(MapUncertainty, AnErrorOfTheScaleGrowsWithTheDistance) {
  MapUncertainty uncertainty;
  const Eigen::Vector3d part(2.0, 0.0, 0.0), pose(12.0, 0.0, 0.0);
  uncertainty.add(1, 0, part, Matrix6d::Zero(), 0.02 * 0.02);
  EXPECT_NEAR(uncertainty.of_pose(1, part, Matrix6d::Zero()).trace(), 0.0, 1e-15);
  const Matrix6d far = uncertainty.of_pose(1, pose, Matrix6d::Zero());
  EXPECT_NEAR(std::sqrt(far(0, 0)), 0.02 * 10.0, 1e-12);
  EXPECT_NEAR(far(1, 1), 0.0, 1e-15);
  uncertainty.add(2, 1, pose, diagonal(0.05, 0.001), 0.01 * 0.01);
  EXPECT_NEAR(uncertainty.of_pose(2, pose, Matrix6d::Zero())(0, 0), 0.2 * 0.2 + 0.05 * 0.05, 1e-12);
  // The errors of both scales are along the way that follows.
  EXPECT_NEAR(uncertainty.of_pose(2, {22.0, 0.0, 0.0}, Matrix6d::Zero())(0, 0), 0.4 * 0.4 + 0.1 * 0.1 + 0.05 * 0.05,
              1e-12);
}

/// A chain of 100 equal steps whose end is known: a Brownian bridge, against its closed form.
TEST(MapUncertainty, AClosedLoopLeavesTheErrorsOfABridge) {
  MapUncertainty uncertainty;
  const Eigen::Vector3d at = Eigen::Vector3d::Zero();
  constexpr int steps = 100;
  for (int k = 1; k <= steps; ++k) uncertainty.add(k, k - 1, at, diagonal(0.01, 0.002), 0.0);
  uncertainty.close_loop(0, steps);
  for (const int k : {1, 10, 50, 90, steps}) {
    const double share = static_cast<double>(k) / steps;
    const Matrix6d covariance = uncertainty.of_pose(k, at, Matrix6d::Zero());
    EXPECT_NEAR(covariance(0, 0), 1e-4 * steps * share * (1.0 - share), 1e-12) << k;
    EXPECT_NEAR(covariance(4, 4), 4e-6 * steps * share * (1.0 - share), 1e-12) << k;
  }
}

TEST(MapUncertainty, APartThatIsGoneTakesNoOtherWithIt) {
  MapUncertainty uncertainty;
  const Eigen::Vector3d at = Eigen::Vector3d::Zero();
  uncertainty.add(1, 0, at, diagonal(0.03, 0.0), 0.0);
  uncertainty.add(2, 1, at, diagonal(0.04, 0.0), 0.0);
  uncertainty.forget(1);
  EXPECT_FALSE(uncertainty.contains(1));
  EXPECT_NEAR(uncertainty.of_pose(2, at, Matrix6d::Zero())(0, 0), 0.05 * 0.05, 1e-12) << "the errors of both";
}

TEST(MapUncertainty, ALoopChangesNothingBeforeIt) {
  MapUncertainty uncertainty;
  const Eigen::Vector3d at = Eigen::Vector3d::Zero();
  for (int k = 1; k <= 20; ++k) uncertainty.add(k, k - 1, at, diagonal(0.01, 0.002), 0.0);
  uncertainty.close_loop(10, 20);
  EXPECT_NEAR(uncertainty.of_pose(5, at, Matrix6d::Zero())(0, 0), 5e-4, 1e-12);
  EXPECT_NEAR(uncertainty.of_pose(10, at, Matrix6d::Zero())(0, 0), 10e-4, 1e-12);
  EXPECT_NEAR(uncertainty.of_pose(15, at, Matrix6d::Zero())(0, 0), 10e-4 + 2.5e-4, 1e-12);
  EXPECT_NEAR(uncertainty.of_pose(20, at, Matrix6d::Zero())(0, 0), 10e-4, 1e-12);
  uncertainty.close_loop(20, 10);
  uncertainty.close_loop(3, 99);
  EXPECT_NEAR(uncertainty.of_pose(20, at, Matrix6d::Zero())(0, 0), 10e-4, 1e-12) << "no loop";
}

/// Two submaps of the same shape: the second has the errors of where it was joined, and of its own.
TEST(MapUncertainty, AJoinedSubmapIsTransformedAndHasTheErrorsOfBoth) {
  MapUncertainty uncertainty;
  const Eigen::Vector3d x(1.0, 0.0, 0.0), origin = Eigen::Vector3d::Zero();
  uncertainty.set(3, x, diagonal(0.1, 0.0));
  Matrix6d own = Matrix6d::Zero();
  own(0, 0) = 0.01;
  uncertainty.set(7, x, own);
  // A quarter turn, twice as large, beside.
  const Sim3 new_from_old(2.0, SO3::exp({0.0, 0.0, M_PI / 2.0}), {1.0, 0.0, 0.0});
  uncertainty.join(7, 3, new_from_old * x, new_from_old);
  uncertainty.join(6, 3, new_from_old * origin, new_from_old);
  const Matrix6d none = Matrix6d::Zero();
  const Matrix6d moved = uncertainty.of_pose(7, {1.0, 2.0, 0.0}, none), first = uncertainty.of_pose(6, x, none);
  EXPECT_NEAR(moved(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(moved(1, 1), 0.01 + 4.0 * 0.01, 1e-12) << "what was x is y now, and twice as long";
  EXPECT_THAT(first, matrix_near(diagonal(0.1, 0.0), 1e-12)) << "the first of a submap was certain";
  ASSERT_EQ(uncertainty.after(3).size(), 2U);
  EXPECT_EQ(uncertainty.after(3).back().first, 7);
  EXPECT_THAT(uncertainty.after(3).back().second, matrix_near(Eigen::Vector3d(1.0, 2.0, 0.0), 1e-12));
}

}  // namespace
}  // namespace rastro
