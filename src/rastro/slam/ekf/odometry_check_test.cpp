// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/odometry_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace rastro {
namespace {

SE2 pose(double x, double angle) { return {SO2::from_angle(angle), {x, 0.0}}; }

TEST(OdometryCheck, MeasuresErrorPerMeter) {
  OdometryCheck check;
  for (int i = 0; i <= 100; ++i) check.add(pose(0.1 * i, 0.0), pose(0.1 * i * 1.03, 0.0), true);
  EXPECT_NEAR(check.result().error_m, 0.03, 1e-9);
  EXPECT_GE(check.result().meters, 9);
  EXPECT_EQ(check.result().rotations, 0);
  EXPECT_NE(describe(check.result()).find("beyond"), std::string::npos);
}

TEST(OdometryCheck, MeasuresErrorPer45DegreesOfRotation) {
  OdometryCheck check;
  for (int i = 0; i <= 100; ++i) check.add(pose(0.0, 0.1 * i), pose(0.0, 0.1 * i * (1.0 + 1.0 / 45.0)), true);
  EXPECT_NEAR(check.result().error_deg, 1.0, 1e-6);
  EXPECT_EQ(check.result().meters, 0);
  EXPECT_NE(describe(check.result()).find("within"), std::string::npos);
}

TEST(OdometryCheck, DoesNotDependOnTheOriginsOrAGap) {
  OdometryCheck check;
  const SE2 other(SO2::from_angle(2.0), {50.0, -3.0});
  for (int i = 0; i <= 50; ++i) {
    if (i == 25) check.interrupt();
    const SE2 world_from_body = pose(0.1 * i, 0.02 * i);
    // Odometry restarts in the middle.
    check.add(i < 25 ? other * world_from_body : world_from_body, world_from_body, true);
  }
  EXPECT_GT(check.result().meters, 2);
  EXPECT_NEAR(check.result().error_m, 0.0, 1e-9);
  EXPECT_NEAR(check.result().error_deg, 0.0, 1e-6);
}

TEST(OdometryCheck, MeasuresOnlyWhereTheFilterKnowsBetter) {
  OdometryCheck check;
  for (int i = 0; i <= 100; ++i) check.add(pose(0.1 * i, 0.0), pose(0.1 * i, 0.0), i == 50 || i == 99);
  EXPECT_EQ(check.result().meters, 0);
  for (int i = 101; i <= 200; ++i) check.add(pose(0.1 * i, 0.0), pose(0.1 * i, 0.0), i % 5 == 0);
  EXPECT_NEAR(check.result().meters, 9, 1);
}

TEST(OdometryCheck, OneLoopClosureDoesNotAffectTheMedian) {
  OdometryCheck check;
  for (int i = 0; i <= 100; ++i) check.add(pose(0.1 * i, 0.0), pose(0.1 * i + (i > 50 ? 3.0 : 0.0), 0.0), true);
  EXPECT_NEAR(check.result().error_m, 0.0, 1e-9);
}

}  // namespace
}  // namespace rastro
