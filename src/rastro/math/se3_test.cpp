// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/se3.h"

#include <gtest/gtest.h>

#include <numbers>

#include "rastro/base/random.h"
#include "rastro/math/math_testing.h"
#include "rastro/math/packed_se3.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::pose_near;

TEST(SE3, QuarterOfACircle) {
  // Driving a quarter of a circle of radius 1 m to the left: forward x, up z.
  Vector6d tangent = Vector6d::Zero();
  tangent << std::numbers::pi / 2.0, 0.0, 0.0, 0.0, 0.0, std::numbers::pi / 2.0;
  const SE3 expected(SO3::exp({0.0, 0.0, std::numbers::pi / 2.0}), {1.0, 1.0, 0.0});
  EXPECT_THAT(SE3::exp(tangent), pose_near(expected, 1e-15, 1e-15));
  const SE3 half = interpolate(SE3(), expected, 0.5);
  EXPECT_NEAR(half.translation().x(), std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(half.translation().y(), 1.0 - std::sqrt(0.5), 1e-15);
}

TEST(SE3, FromMatrixUndoesMatrix) {
  Vector6d tangent;
  tangent << 1.0, -2.0, 3.0, 0.4, 0.5, -2.0;
  const SE3 pose = SE3::exp(tangent);
  EXPECT_THAT(SE3::from_matrix(pose.matrix()), pose_near(pose, 1e-14, 1e-14));
}

TEST(MathTesting, DistantPosesAreNotNear) {
  const SE3 moved(SO3(), {0.1, 0.0, 0.0}), rotated(SO3::exp({0.0, 0.1, 0.0}), Eigen::Vector3d::Zero());
  EXPECT_THAT(moved, pose_near(SE3(), 0.11, 0.0));
  EXPECT_THAT(moved, ::testing::Not(pose_near(SE3(), 0.09, 1.0)));
  EXPECT_THAT(rotated, pose_near(SE3(), 0.0, 0.11));
  EXPECT_THAT(rotated, ::testing::Not(pose_near(SE3(), 1.0, 0.09)));
}

/// Normalized again, a part of them would have other bits.
TEST(PackedSE3, GivesTheSameBitsBack) {
  Random random(3);
  const auto tangent = [&] {
    Vector6d values;
    for (double& value : values) value = random.normal();
    return values;
  };
  SE3 pose;
  for (int k = 0; k < 1000; ++k) {
    pose = pose * SE3::exp(tangent());
    const SE3 same = PackedSE3(pose).pose();
    EXPECT_EQ(same.rotation().quaternion().coeffs(), pose.rotation().quaternion().coeffs());
    EXPECT_EQ(same.translation(), pose.translation());
  }
  EXPECT_EQ(sizeof(PackedSE3), 56U);
}

}  // namespace
}  // namespace rastro
