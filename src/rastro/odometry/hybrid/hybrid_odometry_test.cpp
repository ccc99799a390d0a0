// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/hybrid/hybrid_odometry.h"

#include <gtest/gtest.h>

#include "rastro/odometry/drive_testing.h"

namespace rastro {
namespace {

TEST(HybridOdometry, TracksTheFirstBendWithAndWithoutAPool) {
  const Drive drive = first_bend(0.4);
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

TEST(HybridOdometry, EverySettingIsInItsTable) {
  HybridOptions options;
  EXPECT_GT(option_table(options).options().size(), 20U);
}

}  // namespace
}  // namespace rastro
