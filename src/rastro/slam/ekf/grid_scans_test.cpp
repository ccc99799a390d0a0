// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/grid_scans.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace rastro {
namespace {

LaserScan wall() {
  LaserScan scan;
  scan.angle_step = 0.01;
  scan.max_range = 20.0;
  scan.ranges.assign(100, 5.0F);
  return scan;
}

SE2 ahead(double meters) { return {SO2(), {meters, 0.0}}; }

/// On a circle of 1 m, 120 steps around.
SE2 on_circle(int step) {
  const double angle = 0.01 + 2.0 * std::numbers::pi / 120.0 * (step % 120);
  return {SO2::from_angle(angle), {std::sin(angle), 1.0 - std::cos(angle)}};
}

std::size_t bytes_after_laps(int laps) {
  GridScans scans;
  scans.begin_keyframe();
  for (int step = 0; step < 120 * laps; ++step) scans.add(wall(), on_circle(step), on_circle(step), 1);
  return scans.bytes();
}

TEST(GridScans, AStandstillIsOneScan) {
  GridScans scans;
  scans.begin_keyframe();
  for (int k = 0; k < 100; ++k) scans.add(wall(), ahead(1e-4 * k), ahead(1e-4 * k), 1);
  ASSERT_TRUE(scans.of(0));
  EXPECT_EQ(scans.of(0)->size(), 1U);
  EXPECT_EQ(scans.of(0)->front().points.size(), 100U);
}

TEST(GridScans, TheSamePlacesAgainTakeNoMoreMemory) {
  EXPECT_EQ(bytes_after_laps(30), bytes_after_laps(5));
  EXPECT_LT(bytes_after_laps(30), 2 * bytes_after_laps(1));
}

TEST(GridScans, OneInSoManyOfTheNewOnes) {
  GridScans all, some;
  all.begin_keyframe();
  some.begin_keyframe();
  for (int k = 0; k < 40; ++k) {
    all.add(wall(), ahead(0.05 * k), ahead(0.05 * k), 1);
    some.add(wall(), ahead(0.05 * k), ahead(0.05 * k), 4);
  }
  EXPECT_EQ(all.of(0)->size(), 40U);
  EXPECT_EQ(some.of(0)->size(), 10U);
}

TEST(GridScans, HalfOfThemCanBeDroppedUntilOneIsLeft) {
  GridScans scans;
  for (int k = 0; k < 8; ++k) {
    if (k % 4 == 0) scans.begin_keyframe();
    scans.add(wall(), ahead(0.1 * k), ahead(0.1 * k), 1);
  }
  const auto before = scans.of(0);
  EXPECT_EQ(scans.of(0), before) << "what is finished is not copied";
  const std::size_t bytes = scans.bytes();
  EXPECT_TRUE(scans.thin());
  EXPECT_EQ(before->size(), 4U) << "of a reader";
  EXPECT_EQ(scans.of(0)->size(), 2U);
  EXPECT_EQ(scans.of(1)->size(), 2U);
  EXPECT_LT(scans.bytes(), bytes * 2 / 3);
  EXPECT_TRUE(scans.thin());
  EXPECT_TRUE(scans.thin());
  EXPECT_FALSE(scans.thin());
  EXPECT_EQ(scans.of(0)->size(), 1U);
  EXPECT_FALSE(scans.of(1));
}

}  // namespace
}  // namespace rastro
