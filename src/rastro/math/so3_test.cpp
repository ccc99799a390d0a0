// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/so3.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "rastro/math/lie.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::random_vector;

constexpr double angles[] = {0.0, 1e-12, 1e-6, 1e-3, 0.1, 0.199, 0.201, 1.0, 3.0, std::numbers::pi, 4.0, 6.0};

TEST(SO3, ExpIsTheRodriguesFormulaOfOpenCv) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const auto tangent = random_vector<Eigen::Vector3d>(random, 2.5);
    cv::Mat expected;
    cv::Rodrigues(cv::Vec3d(tangent.x(), tangent.y(), tangent.z()), expected);
    Eigen::Matrix3d matrix;
    cv::cv2eigen(expected, matrix);
    EXPECT_THAT(SO3::exp(tangent).matrix(), matrix_near(matrix, 1e-14));
  }
}

TEST(SO3, ClosedJacobiansEqualTheSeries) {
  Random random(2);
  for (const double angle : angles) {
    const Eigen::Vector3d tangent = angle * random_vector<Eigen::Vector3d>(random, 1.0).normalized();
    const Eigen::Matrix3d right = right_jacobian<SO3>(tangent), left = left_jacobian<SO3>(tangent);
    EXPECT_THAT(SO3::right_jacobian(tangent), matrix_near(right, 1e-13)) << angle;
    EXPECT_THAT(SO3::left_jacobian(tangent), matrix_near(left, 1e-13)) << angle;
    EXPECT_THAT(SO3::right_jacobian_inverse(tangent), matrix_near(right.inverse().eval(), 1e-11)) << angle;
    EXPECT_THAT(SO3::left_jacobian_inverse(tangent), matrix_near(left.inverse().eval(), 1e-11)) << angle;
  }
}

TEST(SO3, LogIsTheShortestVector) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
  EXPECT_THAT(SO3::exp(4.0 * axis).log(), matrix_near(((4.0 - 2.0 * std::numbers::pi) * axis).eval(), 1e-14));
  EXPECT_NEAR(SO3::exp(std::numbers::pi * axis).log().norm(), std::numbers::pi, 1e-14);
}

TEST(SO3, BothQuaternionsOfARotationHaveOneLog) {
  const Eigen::Quaterniond q = SO3::exp({0.3, -0.2, 0.9}).quaternion();
  const Eigen::Quaterniond negative(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_THAT(SO3(negative).log(), matrix_near(SO3(q).log(), 1e-15));
}

TEST(SO3, FromMatrixIsTheNearestRotation) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const SO3 rotation = SO3::exp(random_vector<Eigen::Vector3d>(random, 3.0));
    Eigen::Matrix3d noise;
    for (auto& value : noise.reshaped()) value = random.uniform(-0.01, 0.01);
    const Eigen::Matrix3d noisy = rotation.matrix() + noise;
    const SO3 nearest = SO3::from_matrix(noisy);
    const double distance = (nearest.matrix() - noisy).norm();
    for (int j = 0; j < 20; ++j) {
      const SO3 other = nearest * SO3::exp(random_vector<Eigen::Vector3d>(random, 0.01));
      EXPECT_LE(distance, (other.matrix() - noisy).norm());
    }
  }
}

TEST(SO3, FromMatrixOfAReflectionIsStillARotation) {
  const Eigen::Matrix3d mirror = Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal();
  EXPECT_NEAR(SO3::from_matrix(mirror).matrix().determinant(), 1.0, 1e-14);
  EXPECT_NEAR(SO3::from_matrix(Eigen::Matrix3d::Zero()).matrix().determinant(), 1.0, 1e-14);
}

TEST(MathTesting, MatricesWithNotANumberAreNeverNear) {
  Eigen::Vector3d vector(1.0, 2.0, std::nan(""));
  EXPECT_THAT(vector, ::testing::Not(matrix_near(vector, 1e9)));
  EXPECT_THAT(Eigen::Vector3d(1.0, 2.0, 3.0), ::testing::Not(matrix_near(Eigen::Vector3d(1.0, 2.0, 3.1), 0.05)));
}

}  // namespace
}  // namespace rastro
