// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/calibrate_yaw.h"

#include <gtest/gtest.h>

#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

struct Pairs {
  std::vector<double> shifts, yaws;
};

Pairs pairs(double lambda, double noise_rad, double outlier_share) {
  Random random(7);
  Pairs made;
  for (int i = 0; i < 200; ++i) {
    made.shifts.push_back(random.uniform(-30.0, 30.0));
    const bool wrong = random.uniform() < outlier_share;
    made.yaws.push_back(wrong ? random.uniform(-0.3, 0.3) : lambda * made.shifts.back() + noise_rad * random.normal());
  }
  return made;
}

TEST(CalibrateYaw, IsExactWithoutNoise) {
  const auto exact = pairs(1.0 / 721.0, 0.0, 0.0);
  const auto found = calibrate_yaw(exact.shifts, exact.yaws);
  EXPECT_NEAR(found.lambda, 1.0 / 721.0, 1e-12);
  EXPECT_LT(found.rms_rad, 1e-10);
}

TEST(CalibrateYaw, IsRobustToNoiseAndOutliersWithinItsSigma) {
  const auto noisy = pairs(1.0 / 721.0, 0.001, 0.25);
  const auto found = calibrate_yaw(noisy.shifts, noisy.yaws);
  EXPECT_NEAR(found.lambda, 1.0 / 721.0, 4.0 * found.sigma);
  EXPECT_LT(found.sigma, 0.03 / 721.0);
  EXPECT_LT(found.used, 180);
}

/// As from a robot that waits most of the time: without any motion, and with errors smaller than when it moves.
TEST(CalibrateYaw, ACameraThatMostlyStandsStillChangesNothing) {
  const auto moving = pairs(1.0 / 721.0, 0.001, 0.1);
  const auto alone = calibrate_yaw(moving.shifts, moving.yaws);
  for (const double still_px : {0.0, 1e-4}) {
    Pairs standing = moving;
    standing.shifts.insert(standing.shifts.begin(), 400, still_px);
    standing.yaws.insert(standing.yaws.begin(), 400, 0.0);
    const auto found = calibrate_yaw(standing.shifts, standing.yaws);
    EXPECT_NEAR(found.lambda, alone.lambda, 0.5 * alone.sigma);
    EXPECT_NEAR(found.sigma / alone.sigma, 1.0, 0.05);
  }
}

TEST(CalibrateYaw, GivesAnErrorWithoutRotation) {
  const std::vector<double> shifts{0.1, -0.2, 0.05}, yaws{0.0, 0.0, 0.0};
  EXPECT_THROW(calibrate_yaw(shifts, yaws), Error);
  EXPECT_THROW(calibrate_yaw({}, {}), Error);
}

}  // namespace
}  // namespace rastro
