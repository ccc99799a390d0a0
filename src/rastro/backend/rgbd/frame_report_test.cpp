// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/frame_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <utility>

#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::random_vector;

Matrix6d random_covariance(Random& random) {
  Matrix6d root;
  for (int column = 0; column < 6; ++column) root.col(column) = random_vector<Vector6d>(random, 1.0);
  return root * root.transpose() + 0.1 * Matrix6d::Identity();
}

/// How errors d at the right of the first pose move the error at the right of what is made of it.
template <typename Made>
Matrix6d derivative(const SE3& pose, const Made& made) {
  constexpr double step = 1e-6;
  Matrix6d by_error;
  for (int axis = 0; axis < 6; ++axis) {
    const SE3 disturbed = made(pose * SE3::exp(step * Vector6d::Unit(axis)));
    by_error.col(axis) = (made(pose).inverse() * disturbed).log() / step;
  }
  return by_error;
}

TEST(FrameReport, CovariancesAreChainedAndInvertedAsErrorsAre) {
  Random random(5);
  for (int k = 0; k < 5; ++k) {
    const SE3 a = SE3::exp(random_vector<Vector6d>(random, 1.0)), b = SE3::exp(random_vector<Vector6d>(random, 1.0));
    const Matrix6d of_a = random_covariance(random), of_b = random_covariance(random);
    const Matrix6d by_a = derivative(a, [&](const SE3& pose) { return pose * b; });
    const Matrix6d expected = by_a * of_a * by_a.transpose() + of_b;
    EXPECT_THAT(chained(of_a, b, of_b), matrix_near(expected, 1e-4 * expected.norm()));
    const Matrix6d back = derivative(a, [](const SE3& pose) { return pose.inverse(); });
    const Matrix6d inverse = back * of_a * back.transpose();
    EXPECT_THAT(of_inverse(of_a, a), matrix_near(inverse, 1e-4 * inverse.norm()));
    const Matrix6d information = information_of(of_a);
    EXPECT_THAT(Matrix6d(information * of_a), matrix_near(Matrix6d(Matrix6d::Identity()), 1e-8));
    EXPECT_EQ(information, information.transpose());
  }
}

TEST(FrameReport, InTheWorldsAxesAnErrorIsThatOfThePosition) {
  Random random(6);
  const SE3 pose = SE3::exp(random_vector<Vector6d>(random, 1.0));
  const Matrix6d covariance = random_covariance(random), world = in_world_axes(covariance, pose);
  const Eigen::Matrix3d rotation = pose.rotation().matrix();
  for (const int from : {0, 3}) {
    for (const int to : {0, 3}) {
      const Eigen::Matrix3d block = covariance.block<3, 3>(from, to);
      EXPECT_THAT(Eigen::Matrix3d(world.block<3, 3>(from, to)),
                  matrix_near(Eigen::Matrix3d(rotation * block * rotation.transpose()), 1e-12));
    }
  }
  EXPECT_EQ(world, world.transpose());
}

TEST(FrameReport, ReasonsAndStatesAreThoseOfTheFollower) {
  const std::pair<OdometryReason, SlamReason> reasons[] = {
      {OdometryReason::none, SlamReason::none},
      {OdometryReason::no_motion, SlamReason::none},
      {OdometryReason::pure_rotation, SlamReason::none},
      {OdometryReason::first_frame, SlamReason::first_frame},
      {OdometryReason::too_few_points, SlamReason::too_few_points},
      {OdometryReason::dark_or_blank, SlamReason::dark_or_blank},
      {OdometryReason::blurred, SlamReason::blurred},
      {OdometryReason::repeated_frame, SlamReason::repeated_frame},
      {OdometryReason::gap, SlamReason::gap},
      {OdometryReason::too_little_parallax, SlamReason::few_inliers},
      {OdometryReason::few_inliers, SlamReason::few_inliers},
      {OdometryReason::calibration_doubtful, SlamReason::few_inliers}};
  for (const auto& [followed, said] : reasons) EXPECT_EQ(reason_of(followed), said);
  EXPECT_EQ(state_of(FollowedFeature::State::matched), ObservationState::matched);
  EXPECT_EQ(state_of(FollowedFeature::State::inlier), ObservationState::inlier);
  EXPECT_EQ(state_of(FollowedFeature::State::outlier), ObservationState::outlier);
  EXPECT_EQ(state_of(FollowedFeature::State::fresh), ObservationState::new_landmark);
}

}  // namespace
}  // namespace rastro
