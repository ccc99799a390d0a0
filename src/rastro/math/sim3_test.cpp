// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/sim3.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/math/math_testing.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::random_vector;

TEST(Sim3, OfScaleOneIsTheRigidMotion) {
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    const auto rigid = random_vector<Vector6d>(random, 1.5);
    Vector7d tangent;
    tangent << rigid, 0.0;
    EXPECT_THAT(Sim3::exp(tangent).matrix(), matrix_near(SE3::exp(rigid).matrix(), 1e-14));
    EXPECT_THAT(Sim3(SE3::exp(rigid)).log(), matrix_near(tangent, 1e-13));
  }
}

TEST(Sim3, RoundTripForScalesFromTinyToHuge) {
  Random random(6);
  for (const double log_scale : {-12.0, -3.0, -1e-3, -1e-13, 0.0, 1e-13, 1e-6, 0.5, 3.0, 12.0})
    for (const double angle : {0.0, 1e-10, 1e-3, 0.2999, 0.3001, 3.0}) {
      Vector7d tangent;
      tangent << random_vector<Eigen::Vector3d>(random, 1.0),
          angle * random_vector<Eigen::Vector3d>(random, 1.0).normalized(), log_scale;
      EXPECT_THAT(Sim3::exp(tangent).log(), matrix_near(tangent, 1e-11)) << log_scale << " " << angle;
    }
}

TEST(Sim3, WithoutRotationItIsTheScalarFormula) {
  Vector7d tangent = Vector7d::Zero();
  tangent << 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, std::log(4.0);
  EXPECT_NEAR(Sim3::exp(tangent).translation().x(), 3.0 / std::log(4.0), 1e-14);  // (e^s - 1) / s
  EXPECT_NEAR(interpolate(Sim3(), Sim3::exp(tangent), 0.5).scale(), 2.0, 1e-14);
}

TEST(Sim3, ScaleMustBePositive) {
  EXPECT_THROW(Sim3(0.0, SO3(), Eigen::Vector3d::Zero()), Fault);
  EXPECT_THROW(Sim3(std::nan(""), SO3(), Eigen::Vector3d::Zero()), Fault);
}

}  // namespace
}  // namespace rastro
