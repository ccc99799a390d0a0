// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/odometry/drive_testing.h"
#include "rastro/odometry/profiles/profiles_odometry.h"

namespace rastro {
namespace {

/// Rendered once for all tests.
const Drive& bend() {
  static const Drive drive = first_bend(0.2);
  return drive;
}

TEST(ProfilesOdometry, EstimatesTheRotationOfTheFirstBend) {
  const Drive& drive = bend();
  ProfilesOdometry odometry({}, drive.camera), spoilt({}, drive.camera), still({}, drive.camera),
      dark({}, drive.camera);
  const DriveResult result = run(odometry, drive.frames);
  expect_sound(result, drive.frames.size());
  EXPECT_LE(yaw_error_deg(result.trajectory, drive.ground_truth), 2.0);
  expect_spoilt_frames_are_bridged(spoilt, drive);
  expect_still_and_dark_frames_are_said(still, dark, drive);
}

TEST(ProfilesOdometry, BeforeTheFirstImageNothingIsBridged) {
  const Drive& drive = bend();
  std::vector<Frame> frames(drive.frames.begin(), drive.frames.begin() + 5);
  for (std::size_t k = 0; k < 3; ++k) frames[k].image = {};
  ProfilesOdometry odometry({}, drive.camera);
  const DriveResult result = run(odometry, frames);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(result.updates[k].state, k < 3 ? OdometryState::initializing : OdometryState::tracking) << k;
    EXPECT_EQ(result.updates[k].world_from_camera.translation().norm(), 0.0) << k;
  }
  EXPECT_NEAR(result.updates[4].world_from_camera.translation().norm(), 1.0, 1e-6) << "one step";
}

TEST(ProfilesOdometry, SettingsOutOfRangeAreErrors) {
  const Camera camera{.width = 400, .height = 300, .fx = 300, .fy = 300, .cx = 200, .cy = 150};
  ProfilesOptions options;
  options.rotation.band_top = 0.6;
  EXPECT_THROW(ProfilesOdometry(options, camera), Error);
  EXPECT_THROW(ProfilesOdometry(ProfilesOptions{}, Camera{}), Error);
  options = {};
  options.max_bridged_frames = -1;
  EXPECT_THROW(ProfilesOdometry(options, camera), Error);
  options = {};
  EXPECT_GT(option_table(options).options().size(), 15U);
}

}  // namespace
}  // namespace rastro
