// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/odometry_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rastro/base/error.h"

namespace rastro {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

/// RMS error over many robots of `motion`, divided into steps: meters and radians.
Eigen::Vector2d error_after(const Eigen::Vector3d& motion, int steps, double factor) {
  const int robots = 4000;
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  for (std::uint64_t seed = 0; seed < robots; ++seed) {
    WheelOdometry wheels({.factor = factor}, seed);
    for (int step = 0; step < steps; ++step) wheels.move(SE2::exp(motion / steps));
    const SE2 off = SE2::exp(motion).inverse() * wheels.odometry_from_body();
    squares += Eigen::Vector2d(off.translation().squaredNorm(), std::pow(off.rotation().angle(), 2));
  }
  return (squares / robots).cwiseSqrt();
}

TEST(WheelOdometry, has_an_error_of_2_cm_after_a_meter_and_2_degrees_after_45_for_any_step) {
  for (const int steps : {1, 7, 40}) {
    EXPECT_NEAR(error_after({1.0, 0.0, 0.0}, steps, 1.0).x(), 0.02, 0.0008) << steps;
    EXPECT_NEAR(error_after({0.0, 0.0, 45.0 * degree}, steps, 1.0).y(), 2.0 * degree, 0.08 * degree) << steps;
    EXPECT_NEAR(error_after({0.0, 0.0, -45.0 * degree}, steps, 1.0).y(), 2.0 * degree, 0.08 * degree) << steps;
  }
}

TEST(WheelOdometry, the_factor_multiplies_both_errors) {
  EXPECT_NEAR(error_after({1.0, 0.0, 0.0}, 10, 3.0).x(), 0.06, 0.0024);
  EXPECT_NEAR(error_after({0.0, 0.0, 45.0 * degree}, 10, 3.0).y(), 6.0 * degree, 0.24 * degree);
  EXPECT_NEAR(error_after({1.0, 0.0, 0.5}, 10, 0.0).norm(), 0.0, 1e-12);
}

TEST(WheelOdometry, the_constant_part_grows_with_the_path_length_and_the_rest_with_its_root) {
  const double after_nine = error_after({9.0, 0.0, 0.0}, 20, 1.0).x();
  EXPECT_NEAR(after_nine, 0.02 * std::sqrt(81.0 * 0.49 + 9.0 * 0.51), 0.005);
}

TEST(WheelOdometry, at_rest_nothing_is_counted_and_invalid_options_are_refused) {
  WheelOdometry wheels({}, 5);
  EXPECT_EQ(wheels.move(SE2()).log().norm(), 0.0);
  EXPECT_THROW(WheelOdometry({.factor = -1.0}, 1), Error);
  EXPECT_THROW(WheelOdometry({.factor = std::numeric_limits<double>::quiet_NaN()}, 1), Error);
}

}  // namespace
}  // namespace rastro
