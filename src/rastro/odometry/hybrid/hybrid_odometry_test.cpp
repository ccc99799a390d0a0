// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/hybrid/hybrid_odometry.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/odometry/drive_testing.h"

namespace rastro {
namespace {

/// Rendered once for all tests.
const Drive& bend() {
  static const Drive drive = first_bend(0.4);
  return drive;
}

TEST(HybridOdometry, TracksTheFirstBendWithAndWithoutAPool) {
  const Drive& drive = bend();
  HybridOdometry odometry({}, drive.camera);
  const DriveResult result = run(odometry, drive.frames);
  expect_sound(result, drive.frames.size());
  EXPECT_LE(path_error(result.trajectory, drive.ground_truth), 0.03);
  EXPECT_EQ(result.updates.back().state, OdometryState::tracking);
  TaskPool pool(3);
  HybridOdometry pooled({}, drive.camera, &pool);
  const DriveResult again = run(pooled, drive.frames);
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    EXPECT_EQ(result.trajectory[i].world_from_body.matrix(), again.trajectory[i].world_from_body.matrix()) << i;
  }
  HybridOdometry spoilt({}, drive.camera), still({}, drive.camera), dark({}, drive.camera);
  expect_spoilt_frames_are_bridged(spoilt, drive);
  expect_still_and_dark_frames_are_said(still, dark, drive);
}

Camera small_camera() { return {.width = 64, .height = 48, .fx = 60.0, .fy = 60.0, .cx = 31.5, .cy = 23.5}; }

/// A dark frame repeats the last motion; after two dark ones and a good one, that is the good one's share of the
/// motion.
TEST(HybridOdometry, TheSpeedIsRightAfterBridgedFrames) {
  Drive drive = bend();
  drive.frames.resize(20);
  for (const std::size_t k : {14U, 15U, 17U})
    drive.frames[k].image = GrayImage(drive.camera.width, drive.camera.height);
  HybridOdometry odometry({}, drive.camera);
  const DriveResult result = run(odometry, drive.frames);
  const auto step = [&](std::size_t k) {
    return (result.updates[k].world_from_camera.translation() - result.updates[k - 1].world_from_camera.translation())
        .norm();
  };
  ASSERT_EQ(result.updates[16].state, OdometryState::tracking);
  EXPECT_NEAR(step(17), step(13), 0.2 * step(13));
}

TEST(HybridOdometry, BeforeTheFirstImageNothingIsBridged) {
  HybridOdometry odometry({}, small_camera());
  for (int k = 0; k < 20; ++k) {
    Frame dark;
    dark.stamp = k * 100'000'000LL;
    EXPECT_EQ(odometry.process(dark).state, OdometryState::initializing) << k;
  }
}

TEST(HybridOdometry, SettingsOutOfRangeAreAnError) {
  HybridOptions options;
  options.min_points = 1;
  EXPECT_THROW(HybridOdometry(options, small_camera()), Error);
}

TEST(HybridOdometry, EverySettingIsInItsTable) {
  HybridOptions options;
  EXPECT_GT(option_table(options).options().size(), 20U);
}

}  // namespace
}  // namespace rastro
