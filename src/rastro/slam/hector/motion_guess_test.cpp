// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/motion_guess.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

using testing::pose_of;

constexpr TimeNs period = ns_per_second / 10;

double distance(const SE2& a, const SE2& b) { return (a.matrix() - b.matrix()).norm(); }

TEST(MotionGuess, UsesTheMotionOfOdometryBetweenTwoScans) {
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

TEST(MotionGuess, WithoutOdometryTheLastStepIsRepeated) {
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

TEST(MotionGuess, SigmasAreAFloorAndAShareOfTheMotion) {
  HectorOptions options;
  options.odometry_sigma_share = 0.1, options.odometry_yaw_sigma_share = 0.25;
  MotionGuess guess(options);
  guess.settle(0, pose_of(0.0, 0.0, 0.0), SE2());
  ScanGuess found = guess.guess(period, pose_of(0.3, 0.4, -0.2));
  EXPECT_NEAR(found.sigma_m, 0.02 + 0.1 * 0.5, 1e-12);
  EXPECT_NEAR(found.sigma_rad, 0.01 + 0.25 * 0.2, 1e-12);
  guess.settle(period, {}, pose_of(0.3, 0.4, -0.2));
  found = guess.guess(2 * period, {});
  EXPECT_NEAR(found.sigma_m, 0.05 + 0.5 * 0.5, 1e-12);
  EXPECT_NEAR(found.sigma_rad, 0.05 + 0.5 * 0.2, 1e-12);
  EXPECT_TRUE(found.trusted);
}

TEST(MotionGuess, ConstantVelocityIgnoresOdometry) {
  HectorOptions options;
  options.guess = "constant-velocity";
  MotionGuess guess(options);
  guess.settle(0, pose_of(0.0, 0.0, 0.0), SE2());
  guess.settle(period, pose_of(1.0, 0.0, 0.0), pose_of(0.2, 0.0, 0.1));
  const ScanGuess found = guess.guess(2 * period, pose_of(2.0, 0.0, 0.0));
  EXPECT_LT(distance(found.local_from_body, pose_of(0.2, 0.0, 0.1) * pose_of(0.2, 0.0, 0.1)), 1e-12);
}

TEST(MotionGuess, OdometryThatWasMissingBeforeGivesNoMotion) {
  const HectorOptions options;
  MotionGuess guess(options);
  guess.settle(0, pose_of(0.0, 0.0, 0.0), SE2());
  guess.settle(period, {}, pose_of(0.2, 0.0, 0.0));
  EXPECT_LT(distance(guess.guess(2 * period, pose_of(7.0, 0.0, 0.0)).local_from_body, pose_of(0.4, 0.0, 0.0)), 1e-12);
  EXPECT_FALSE(guess.odometry_jumped()) << "there is nothing to compare with";
}

TEST(MotionGuess, AfterALongPauseAtMostFiveSecondsOfDrivingAreAssumed) {
  HectorOptions options;
  options.max_speed_m_per_s = 2.0;
  MotionGuess guess(options);
  guess.settle(0, pose_of(0.0, 0.0, 0.0), SE2());
  guess.guess(1000 * period, pose_of(9.9, 0.0, 0.0));
  EXPECT_FALSE(guess.odometry_jumped());
  const ScanGuess found = guess.guess(1000 * period, pose_of(10.1, 0.0, 0.0));
  EXPECT_TRUE(guess.odometry_jumped());
  EXPECT_LT(distance(found.local_from_body, SE2()), 1e-12) << "it stood still before";
  guess.guess(1000 * period, pose_of(std::nan(""), 0.0, 0.0));
  EXPECT_TRUE(guess.odometry_jumped());
}

/// A guess after `scans` periods with steps of 0.2 m, the last of them at scan `scans`.
MotionGuess moved_steadily(const HectorOptions& options, int scans) {
  MotionGuess guess(options);
  for (int k = 0; k <= scans; ++k) guess.settle(k * period, {}, pose_of(0.2 * k, 0.0, 0.0));
  return guess;
}

TEST(MotionGuess, ScansAreCountedOnceEnoughPeriodsAreKnown) {
  const HectorOptions options;
  const auto ahead_m = [&](int scans, double later) {
    const MotionGuess guess = moved_steadily(options, scans);
    const auto stamp = static_cast<TimeNs>((scans + later) * static_cast<double>(period));
    return MotionGuess(guess).guess(stamp, {}).local_from_body.translation().x() - 0.2 * scans;
  };
  EXPECT_NEAR(ahead_m(14, 4.0), 0.2, 1e-9) << "fourteen periods are not enough";
  EXPECT_NEAR(ahead_m(15, 4.0), 0.8, 1e-6);
  EXPECT_NEAR(ahead_m(15, 2.9), 0.2, 1e-9) << "fewer than three scans are one";
  EXPECT_NEAR(ahead_m(15, 3.1), 0.62, 1e-6);
  EXPECT_NEAR(ahead_m(40, 4.9), 0.98, 1e-6);
  EXPECT_NEAR(ahead_m(40, 5.1), 1.0, 1e-9) << "and no more than five";
}

TEST(MotionGuess, AStepOverMissingScansIsDividedAmongThem) {
  const HectorOptions options;
  MotionGuess guess = moved_steadily(options, 20);
  guess.settle(24 * period, {}, pose_of(4.8, 0.0, 0.0));  // 0.8 m in four periods
  EXPECT_NEAR(guess.guess(25 * period, {}).local_from_body.translation().x(), 5.0, 1e-9);
}

/// As some logs have it: 5 scans a second, read several at once.
TEST(MotionGuess, StampsOfWhenScansWereReadTellNoMissingOnes) {
  const HectorOptions options;
  const auto milliseconds = [](int ms) { return static_cast<TimeNs>(ms) * 1'000'000; };
  for (const std::vector<int>& periods_ms :
       {std::vector{530, 1, 70}, {550, 50, 1}, {600, 1, 1}, {200, 200, 160, 760, -320}}) {
    MotionGuess guess(options);
    TimeNs stamp = milliseconds(1000);
    for (std::size_t k = 0; k <= 45; ++k) {
      const SE2 pose = pose_of(0.06 * static_cast<double>(k), 0.0, 0.0);
      if (k >= 16) {
        EXPECT_LT(distance(guess.guess(stamp, {}).local_from_body, pose), 1e-9) << k << ' ' << periods_ms.front();
      }
      guess.settle(stamp, {}, pose);
      stamp += milliseconds(periods_ms[k % periods_ms.size()]);
    }
    const SE2 late = guess.guess(stamp + milliseconds(1200), {}).local_from_body;
    EXPECT_LT(distance(late, pose_of(0.06 * 46, 0.0, 0.0)), 1e-9);
  }
}

TEST(MotionGuess, AFewMissingScansAmongRegularOnesAreCounted) {
  const HectorOptions options;
  MotionGuess guess(options);
  int at = 0;
  for (int k = 0; k <= 40; ++k) {
    guess.settle(at * period, {}, pose_of(0.2 * at, 0.0, 0.0));
    at += k % 5 == 4 ? 4 : 1;
  }
  EXPECT_NEAR(guess.guess((at + 3) * period, {}).local_from_body.translation().x(), 0.2 * (at + 3), 1e-9);
}

TEST(MotionGuess, WhatAGuessWasWrongByIsNoSpeed) {
  const HectorOptions options;
  MotionGuess guess(options);
  const auto turned = [](double angle) { return pose_of(0.0, 0.0, angle); };
  guess.settle(0, {}, turned(0.0));
  guess.settle(period, {}, turned(0.2));
  for (const int k : {2, 3}) {
    EXPECT_LT(distance(guess.guess(k * period, {}).local_from_body, turned(0.2 * k)), 1e-9);
    guess.settle_unseen(k * period, {}, turned(0.2 * k));
  }
  guess.settle(4 * period, {}, turned(0.5));  // 0.3 in three scans
  EXPECT_LT(distance(guess.guess(5 * period, {}).local_from_body, turned(0.6)), 1e-9);
}

TEST(MotionGuess, AnUntrustedOneIsTheLastPose) {
  HectorOptions options;
  options.guess = "none";
  MotionGuess guess(options);
  guess.settle(0, pose_of(0.0, 0.0, 0.0), pose_of(1.0, 2.0, 3.0));
  const ScanGuess found = guess.guess(period, pose_of(1.0, 0.0, 0.0));
  EXPECT_FALSE(found.trusted);
  EXPECT_LT(distance(found.local_from_body, pose_of(1.0, 2.0, 3.0)), 1e-12);
  EXPECT_EQ(found.sigma_m, 0.2);
  EXPECT_EQ(found.sigma_rad, 0.2);
}

TEST(MotionGuess, FasterThanAllowedIsAJump) {
  HectorOptions options;
  options.max_speed_m_per_s = 2.0;
  MotionGuess guess(options);
  guess.settle(0, pose_of(0.0, 0.0, 0.0), SE2());
  // At least one second is assumed, since the stamps of some logs are no more accurate.
  guess.guess(period, pose_of(1.99, 0.0, 0.0));
  EXPECT_FALSE(guess.odometry_jumped());
  guess.guess(period, pose_of(2.01, 0.0, 0.0));
  EXPECT_TRUE(guess.odometry_jumped());
  guess.guess(20 * period, pose_of(3.9, 0.0, 0.0));
  EXPECT_FALSE(guess.odometry_jumped()) << "two seconds";
}

/// After 20 scans of 0.05 m each, with odometry that agrees.
MotionGuess with_odometry(const HectorOptions& options) {
  MotionGuess guess(options);
  for (int k = 0; k < 20; ++k) {
    const SE2 pose = pose_of(0.05 * k, 0.0, 0.0);
    guess.guess(k * period, pose);
    guess.settle(k * period, pose, pose);
  }
  return guess;
}

TEST(MotionGuess, OnceThePeriodIsKnownAJumpIsJudgedByIt) {
  const HectorOptions options;
  MotionGuess guess = with_odometry(options);
  const SE2 ahead = guess.guess(20 * period, pose_of(3.0, 0.0, 0.0)).local_from_body;
  EXPECT_TRUE(guess.odometry_jumped()) << "2 m in 0.1 s";
  EXPECT_LT(distance(ahead, pose_of(1.0, 0.0, 0.0)), 1e-9) << "the usual step instead";
  guess.guess(20 * period, pose_of(2.4, 0.0, 0.0));
  EXPECT_FALSE(guess.odometry_jumped()) << "a step and a half may have passed";
}

TEST(MotionGuess, OdometryThatStaysWhileScansMoveIsNotBelieved) {
  const HectorOptions options;
  MotionGuess guess = with_odometry(options);
  const SE2 frozen = pose_of(0.95, 0.0, 0.0);
  int k = 20;
  for (; k < 40; ++k) {
    const double x = guess.guess(k * period, frozen).local_from_body.translation().x();
    EXPECT_NEAR(x, k <= 30 ? 0.05 * (k - 1) : 0.05 * k, 1e-9) << k;
    guess.settle(k * period, frozen, pose_of(0.05 * k, 0.0, 0.0));
  }
  // Its first step is of the whole time.
  EXPECT_NEAR(guess.guess(k * period, pose_of(2.0, 0.0, 0.0)).local_from_body.translation().x(), 0.05 * k, 1e-9);
  guess.settle(k * period, pose_of(2.0, 0.0, 0.0), pose_of(0.05 * k, 0.0, 0.0));
  const SE2 believed = guess.guess((k + 1) * period, pose_of(2.1, 0.0, 0.0)).local_from_body;
  EXPECT_NEAR(believed.translation().x(), 0.05 * k + 0.1, 1e-9);
}

TEST(MotionGuess, OdometryOfAnotherUnitIsGivenUp) {
  const HectorOptions options;
  MotionGuess guess = with_odometry(options);
  SE2 odometry = pose_of(0.95, 0.0, 0.0);
  EXPECT_FALSE(guess.odometry_is_given_up());
  for (int k = 20; k < 40; ++k) {
    odometry = odometry * pose_of(50.0, 0.0, 0.0);
    guess.guess(k * period, odometry);
    EXPECT_TRUE(guess.odometry_jumped());
    guess.settle(k * period, odometry, pose_of(0.05 * k, 0.0, 0.0));
  }
  EXPECT_LT(
      distance(guess.guess(40 * period, odometry * pose_of(0.6, 0.0, 0.0)).local_from_body, pose_of(2.0, 0.0, 0.0)),
      1e-9)
      << "a plausible step by chance";
  EXPECT_TRUE(guess.odometry_is_given_up());
}

TEST(MotionGuess, OdometryIsScaledOnceScansSayItsScale) {
  const HectorOptions options;
  for (const bool by_scan : {true, false}) {
    MotionGuess guess(options);
    for (int k = 0; k <= 100; ++k)
      guess.settle(k * period, pose_of(0.1 * k, 0.0, 0.0), pose_of(0.05 * k, 0.0, 0.0), by_scan);
    const double ahead = guess.guess(101 * period, pose_of(10.2, 0.0, 0.1)).local_from_body.translation().x() - 5.0;
    EXPECT_NEAR(ahead, by_scan ? 0.1 : 0.2, 1e-9);
  }
}

TEST(MotionGuess, ManyPeriodsWithoutAScanAreAGap) {
  const HectorOptions options;
  const MotionGuess guess = with_odometry(options);
  EXPECT_EQ(guess.gap_s(20 * period), 0.0);
  EXPECT_EQ(guess.gap_s(27 * period), 0.0);
  EXPECT_NEAR(guess.gap_s(49 * period), 3.0, 1e-9);
}

TEST(MotionGuess, FramesThatTellNothingNeitherEndAGapNorItsErrors) {
  const HectorOptions options;
  MotionGuess guess = with_odometry(options);
  const auto pose_at = [](int k) { return pose_of(0.05 * k, 0.0, 0.0); };
  for (int k = 20; k < 49; ++k) {
    const SE2 guessed = guess.guess(k * period, pose_at(k)).local_from_body;
    guess.settle_unseen(k * period, pose_at(k), guessed);
  }
  EXPECT_NEAR(guess.gap_s(49 * period), 3.0, 1e-9);
  const ScanGuess found = guess.guess(49 * period, pose_at(49));
  EXPECT_LT(distance(found.local_from_body, pose_at(49)), 1e-9);
  EXPECT_NEAR(found.sigma_m, 0.02 + options.odometry_sigma_share * 0.05 * 30, 1e-9) << "of the whole way";
  guess.settle(49 * period, pose_at(49), pose_at(49));
  EXPECT_EQ(guess.gap_s(50 * period), 0.0);
  EXPECT_NEAR(guess.guess(50 * period, pose_at(50)).sigma_m, 0.02 + options.odometry_sigma_share * 0.05, 1e-9);
}

TEST(MotionGuess, StepsFromAGuessToAScanTellNoScaleOfOdometry) {
  const HectorOptions options;
  MotionGuess guess(options);
  for (int k = 0; k <= 100; ++k) {
    const SE2 odometry = pose_of(0.1 * k, 0.0, 0.0);
    const SE2 guessed = guess.guess(k * period, odometry).local_from_body;
    if (k % 2 == 1) guess.settle_unseen(k * period, odometry, guessed);
    if (k % 2 == 0) guess.settle(k * period, odometry, pose_of(0.075 * k, 0.0, 0.0), true);
  }
  EXPECT_EQ(guess.odometry_scale(), 1.0);
}

}  // namespace
}  // namespace rastro
