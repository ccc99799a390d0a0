// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/motion_guess.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

using testing::pose_of;

constexpr TimeNs period = ns_per_second / 10;

double distance(const SE2& a, const SE2& b) { return (a.matrix() - b.matrix()).norm(); }

TEST(MotionGuess, GoesOnByWhatOdometrySaysBetweenTwoScans) {
  const HectorOptions options;
  MotionGuess guess(options);
  const SE2 odometry = pose_of(5.0, 6.0, 2.0), local = pose_of(1.0, 2.0, 0.3), motion = pose_of(0.4, 0.1, 0.2);
  guess.settle(period, odometry, local);
  const ScanGuess found = guess.guess(2 * period, odometry * motion);
  EXPECT_LT(distance(found.local_from_body, local * motion), 1e-12);
  EXPECT_TRUE(found.trusted);
  const ScanGuess farther = guess.guess(2 * period, odometry * pose_of(0.8, 0.1, 0.4));
  EXPECT_GT(farther.sigma_m, found.sigma_m);
  EXPECT_GT(farther.sigma_rad, found.sigma_rad);
  EXPECT_FALSE(guess.odometry_jumped());
}

TEST(MotionGuess, WithoutOdometryTheLastStepIsTakenAgain) {
  const HectorOptions options;
  MotionGuess guess(options);
  const SE2 step = pose_of(0.2, 0.01, 0.05);
  SE2 pose = pose_of(1.0, -1.0, 0.5);
  for (int k = 0; k < 20; ++k, pose = pose * step) {
    const SE2 found = guess.guess(k * period, {}).local_from_body;
    EXPECT_TRUE(k < 2 || distance(found, pose) < 1e-9) << k;
    guess.settle(k * period, {}, pose);
  }
  EXPECT_LT(distance(guess.last() * step, pose), 1e-9);
  // Three periods without a scan: three steps; a long pause: no more than five.
  const SE2 three = guess.last() * pose_of(0.6, 0.03, 0.15), five = guess.last() * pose_of(1.0, 0.05, 0.25);
  EXPECT_LT(distance(guess.guess(22 * period, {}).local_from_body, three), 1e-9);
  EXPECT_LT(distance(guess.guess(500 * period, {}).local_from_body, five), 1e-9);
}

TEST(MotionGuess, AnUntrustedOneIsWhereTheLastScanWas) {
  HectorOptions options;
  options.guess = "none";
  MotionGuess guess(options);
  guess.settle(0, pose_of(0.0, 0.0, 0.0), pose_of(1.0, 2.0, 3.0));
  const ScanGuess found = guess.guess(period, pose_of(1.0, 0.0, 0.0));
  EXPECT_FALSE(found.trusted);
  EXPECT_LT(distance(found.local_from_body, pose_of(1.0, 2.0, 3.0)), 1e-12);
}

TEST(MotionGuess, FasterThanAllowedIsAJump) {
  HectorOptions options;
  options.max_speed_m_per_s = 2.0;
  MotionGuess guess(options);
  guess.settle(0, pose_of(0.0, 0.0, 0.0), SE2());
  // A second at least is allowed for, as stamps are no better than that in some logs.
  guess.guess(period, pose_of(1.99, 0.0, 0.0));
  EXPECT_FALSE(guess.odometry_jumped());
  guess.guess(period, pose_of(2.01, 0.0, 0.0));
  EXPECT_TRUE(guess.odometry_jumped());
  guess.guess(20 * period, pose_of(3.9, 0.0, 0.0));
  EXPECT_FALSE(guess.odometry_jumped()) << "two seconds";
}

}  // namespace
}  // namespace rastro
