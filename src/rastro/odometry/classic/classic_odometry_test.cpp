// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/classic/classic_odometry.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/odometry/drive_testing.h"

namespace rastro {
namespace {

ClassicOptions options_of_build() {
  ClassicOptions options;
  if (!has_surf()) options.matcher = "sift";
  return options;
}

const Drive& drive() {
  static const Drive rendered = first_bend(0.4);
  return rendered;
}

TEST(ClassicOdometry, TracksTheFirstBend) {
  ClassicOdometry odometry(options_of_build(), drive().camera);
  const DriveResult result = run(odometry, drive().frames);
  expect_sound(result, drive().frames.size());
  EXPECT_LE(path_error(result.trajectory, drive().ground_truth), 0.08);
  EXPECT_EQ(result.updates.back().state, OdometryState::tracking);
  int inliers = 0;
  for (const OdometryFeature& feature : odometry.features()) inliers += feature.state == OdometryFeature::State::inlier;
  EXPECT_EQ(inliers, result.updates.back().inliers);
  ClassicOdometry spoilt(options_of_build(), drive().camera), still(options_of_build(), drive().camera),
      dark(options_of_build(), drive().camera);
  expect_spoilt_frames_are_bridged(spoilt, drive());
  expect_still_and_dark_frames_are_said(still, dark, drive());
}

TEST(ClassicOdometry, EveryMatcherFollowsTheDrive) {
  const std::vector<Frame> frames(drive().frames.begin(), drive().frames.begin() + 5);
  for (const char* matcher : {"sift", "orb"}) {
    ClassicOptions options;
    options.matcher = matcher;
    ClassicOdometry odometry(options, drive().camera);
    EXPECT_EQ(run(odometry, frames).updates.back().state, OdometryState::tracking) << matcher;
  }
}

TEST(ClassicOdometry, SettingsOutOfRangeAreAnError) {
  ClassicOptions options = options_of_build();
  options.min_points = 3;
  EXPECT_THROW(ClassicOdometry(options, Camera{}), Error);
}

/// METHODS 2.1: SURF by default, as in the paper.
TEST(ClassicOdometry, UsesThePapersDescriptorByDefault) {
  ClassicOptions options;
  const OptionTable table = option_table(options);
  EXPECT_EQ(table.options().front().name, "matcher");
  EXPECT_EQ(table.default_of(0), "surf");
}

}  // namespace
}  // namespace rastro
