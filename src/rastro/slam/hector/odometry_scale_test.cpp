// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/odometry_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace rastro {
namespace {

using Eigen::Vector2d;

/// Steps of about 5 cm, by scans known to a centimeter, by odometry 1 / `factor` times as long.
void drive(OdometryScale& scale, double factor, int steps, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (int k = 0; k < steps; ++k) {
    const Vector2d moved(0.05, 0.01 * std::sin(0.1 * k));
    scale.add(moved / factor, moved + Vector2d(noise(random), noise(random)));
  }
}

TEST(OdometryScale, RightOdometryStaysAsItIs) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    OdometryScale scale;
    drive(scale, 0.93 + 0.003 * seed, 500, seed);
    EXPECT_EQ(scale.factor(), 1.0) << seed;
  }
}

TEST(OdometryScale, AnotherOneIsFoundWithinTwoAndAHalfMeters) {
  for (const double factor : {-1.0, 0.3, 0.5, 0.7, 1.5, 1.0 / 2.54, 2.54, 3.5}) {
    OdometryScale scale;
    drive(scale, factor, 50, 1);
    EXPECT_NEAR(scale.factor(), factor, 0.06 * std::abs(factor)) << factor;
    drive(scale, factor, 300, 2);
    EXPECT_NEAR(scale.factor(), factor, 0.03 * std::abs(factor)) << factor;
  }
}

TEST(OdometryScale, AnotherUnitIsNotMadeUpFor) {
  for (const double factor : {0.01, 1.0 / 39.37, 0.2, 5.0, 100.0}) {
    OdometryScale scale;
    drive(scale, factor, 500, 3);
    EXPECT_EQ(scale.factor(), 1.0) << factor;
  }
}

TEST(OdometryScale, OdometryOfAnotherDriveHasNone) {
  OdometryScale scale;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-0.1, 0.1);
  for (int k = 0; k < 2000; ++k) scale.add({any(random), any(random)}, {0.05, 0.0});
  EXPECT_EQ(scale.factor(), 1.0);
}

TEST(OdometryScale, TheErrorIsUnknownUntilManyStretchesShowIt) {
  OdometryScale scale;
  drive(scale, 1.0, 100, 7);
  EXPECT_EQ(scale.error(0.1).share, 0.1);
  EXPECT_EQ(scale.error(0.1).variance_per_m, 0.0);
  drive(scale, 1.0, 200, 8);
  EXPECT_LT(scale.error(0.1).share, 0.05);
  EXPECT_GT(scale.error(0.1).variance_per_m, 0.0);
}

/// Too little to be made up for, and more than is assumed of an unknown robot.
TEST(OdometryScale, AnErrorLargerThanExpectedIsSaid) {
  for (const double factor : {0.86, 1.14}) {
    OdometryScale scale;
    drive(scale, factor, 400, 9);
    EXPECT_EQ(scale.factor(), 1.0);
    EXPECT_GT(scale.error(0.1).share, 0.9 * std::abs(factor - 1.0)) << factor;
  }
}

/// Wheels of another size by a normal share, and slip that is independent from step to step: learned over 30 m, for 10
/// m that no scan shows.
TEST(OdometryScale, TheErrorIsAsLargeAsWhatHappensWhereScansDoNotTell) {
  constexpr double step_m = 0.05, slip_per_m = 0.02, cells_m = 0.003;
  constexpr int drives = 300;
  double squared_sigmas = 0.0;
  for (unsigned seed = 0; seed < drives; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const double wheels = 0.02 * normal(random);
    const auto by_odometry = [&] { return step_m * (1.0 + wheels) + slip_per_m * std::sqrt(step_m) * normal(random); };
    OdometryScale scale;
    double last = 0.0;
    for (int k = 0; k < 600; ++k) {
      const double cells = cells_m * normal(random);
      scale.add({by_odometry(), 0.0}, {step_m + cells - last, 0.0});
      last = cells;
    }
    double error_m = 0.0;
    for (int k = 0; k < 200; ++k) error_m += by_odometry() - step_m;
    const OdometryError error = scale.error(0.1);
    squared_sigmas += error_m * error_m / (error.share * error.share * 100.0 + error.variance_per_m * 10.0) / drives;
  }
  EXPECT_GT(squared_sigmas, 0.6);
  EXPECT_LT(squared_sigmas, 1.1);
}

TEST(OdometryScale, AJumpAndStandingStillSayNothing) {
  OdometryScale scale;
  drive(scale, 0.5, 50, 5);
  const double found = scale.factor();
  for (int k = 0; k < 100; ++k) scale.add(Vector2d::Zero(), Vector2d::Zero());
  scale.add({7.0, 0.0}, {0.05, 0.0});
  drive(scale, 0.5, 20, 6);
  EXPECT_NEAR(scale.factor(), found, 0.02);
}

}  // namespace
}  // namespace rastro
