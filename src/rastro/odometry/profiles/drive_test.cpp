// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/odometry/drive_testing.h"
#include "rastro/odometry/profiles/profiles_odometry.h"

namespace rastro {
namespace {

TEST(ProfilesOdometry, EstimatesTheRotationOfTheFirstBend) {
  const Drive drive = first_bend(0.2);
  ProfilesOdometry odometry({}, drive.camera), spoilt({}, drive.camera), still({}, drive.camera),
      dark({}, drive.camera);
  const DriveResult result = run(odometry, drive.frames);
  expect_sound(result, drive.frames.size());
  EXPECT_LE(yaw_error_deg(result.trajectory, drive.ground_truth), 2.0);
  expect_spoilt_frames_are_bridged(spoilt, drive);
  expect_still_and_dark_frames_are_said(still, dark, drive);
}

TEST(ProfilesOdometry, SettingsOutOfRangeAreErrors) {
  const Camera camera{.width = 400, .height = 300, .fx = 300, .fy = 300, .cx = 200, .cy = 150};
  ProfilesOptions options;
  options.rotation.band_top = 0.6;
  EXPECT_THROW(ProfilesOdometry(options, camera), Error);
  EXPECT_THROW(ProfilesOdometry(ProfilesOptions{}, Camera{}), Error);
  EXPECT_GT(option_table(options).options().size(), 15U);
}

}  // namespace
}  // namespace rastro
