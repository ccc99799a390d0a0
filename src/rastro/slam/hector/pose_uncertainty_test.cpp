// SPDX-License-Identifier: Apache-2.0
// How sure the reported poses are.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rastro/math/math_testing.h"
#include "rastro/slam/hector/hector_slam.h"
#include "rastro/slam/hector/hector_testing.h"
#include "rastro/slam/hector/motion_guess.h"
#include "rastro/slam/hector/scan_follower.h"

namespace rastro {
namespace {

using testing::pose_of;
using testing::room_drive;
using testing::WalledDrive;

/// Of x, y and the angle, as the matcher gives it.
Eigen::Matrix3d planar_part(const Matrix6d& covariance) {
  Eigen::Matrix3d part;
  const int axes[] = {0, 1, 5};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) part(i, j) = covariance(axes[i], axes[j]);
  return part;
}

/// 0.6 cells and 2 mrad beyond what the matcher says of the second scan.
TEST(HectorSlam, TheCovarianceIsThatOfTheMatchAndOfTheCells) {
  const std::vector<Frame> frames = room_drive(2).frames();
  for (const double cell_m : {0.05, 0.08}) {
    HectorOptions options;
    options.cell_m = cell_m;
    HectorSlam slam(options, nullptr);
    slam.process(frames[0]);
    const SlamUpdate update = slam.process(frames[1]);
    Submap first(options, SE2());
    first.insert(returns_of(*frames[0].scan, options), SE2(), 0);
    MotionGuess motion(options);
    motion.settle(frames[0].stamp, frames[0].odometry_from_body, SE2());
    const FollowedScan followed =
        ScanFollower(options).follow(first, returns_of(*frames[1].scan, options).points,
                                     motion.guess(frames[1].stamp, frames[1].odometry_from_body));
    Eigen::Matrix3d expected = followed.covariance;
    expected.diagonal() += Eigen::Vector3d(0.36 * cell_m * cell_m, 0.36 * cell_m * cell_m, 4e-6);
    ASSERT_TRUE(update.covariance);
    EXPECT_THAT(planar_part(*update.covariance), testing::matrix_near(expected, 1e-9));
    EXPECT_EQ(update.score, followed.score);
  }
}

/// Along a bare corridor to its end, which shows how far it was; odometry's share of the path remains.
TEST(HectorSlam, WhatOdometryMayHaveSlippedWhereNothingWasSeenStays) {
  WalledDrive drive;
  drive.walls.add_box(-40.0, -1.0, 12.0, 1.0);
  drive.reach_m = 6.0;
  drive.world_from_body = {pose_of(0.0, 0.1, 0.0)};
  drive.go(pose_of(0.1, 0.0, 0.0), 90);
  HectorOptions options;
  options.submap_scans = 1000;
  HectorSlam slam(options, nullptr);
  double unseen_m = 0.0;
  SlamUpdate update;
  for (const Frame& frame : drive.frames()) {
    update = slam.process(frame);
    if (update.reason == SlamReason::degenerate) {
      EXPECT_EQ(update.state, SlamState::weak);
      unseen_m += 0.1;
      EXPECT_LT(update.covariance->coeff(1, 1), 0.01);
    }
  }
  EXPECT_GT(unseen_m, 5.0);
  EXPECT_EQ(update.state, SlamState::tracking);
  const double slip_m = options.odometry_sigma_share * unseen_m;
  EXPECT_NEAR(std::sqrt(update.covariance->coeff(0, 0)) / slip_m, 1.0, 0.05);
  EXPECT_LT(update.covariance->coeff(1, 1), 0.01);
}

/// Pillars first, by which scans tell how far odometry is off, then bare walls.
TEST(HectorSlam, WheelsThatWereRightSlipLess) {
  WalledDrive drive;
  drive.walls.add({-50.0, -1.5}, {50.0, -1.5});
  drive.walls.add({-50.0, 1.5}, {50.0, 1.5});
  for (const double x : {-24.0, -20.5, -18.2, -15.0, -11.3, -8.1, -6.0, -3.2, 0.0})
    drive.walls.add_box(x, 1.0, x + 0.5, 1.5);
  drive.reach_m = 6.0;
  drive.world_from_body = {pose_of(-20.0, 0.1, 0.0)};
  drive.go(pose_of(0.1, 0.0, 0.0), 350);
  const HectorOptions options;
  HectorSlam slam(options, nullptr);
  double unseen_m = 0.0;
  SlamUpdate update;
  for (const Frame& frame : drive.frames()) {
    update = slam.process(frame);
    unseen_m = update.reason == SlamReason::degenerate ? unseen_m + 0.1 : 0.0;
  }
  EXPECT_GT(unseen_m, 5.0);
  EXPECT_LT(std::sqrt(update.covariance->coeff(0, 0)), 0.3 * options.odometry_sigma_share * unseen_m);
}

/// Submaps that begin in the corridor have the slip up to there, and what is matched with them no more than all.
TEST(HectorSlam, SlipAlongACorridorCountsOnceHoweverManySubmapsBegin) {
  WalledDrive drive;
  drive.walls.add({-50.0, -1.0}, {50.0, -1.0});
  drive.walls.add({-50.0, 1.0}, {50.0, 1.0});
  drive.reach_m = 6.0;
  drive.world_from_body = {pose_of(0.0, 0.1, 0.0)};
  drive.go(pose_of(0.1, 0.0, 0.0), 80);
  HectorOptions options;
  options.submap_scans = 10;
  HectorSlam slam(options, nullptr);
  std::size_t submaps = 0;
  for (const Frame& frame : drive.frames()) {
    const SlamUpdate update = slam.process(frame);
    for (const SlamEvent& event : update.events) submaps += event.kind == "submap" ? 1 : 0;
    if (frame.index < 30) continue;
    ASSERT_EQ(update.reason, SlamReason::degenerate);
    const double slip_m = options.odometry_sigma_share * 0.1 * static_cast<double>(frame.index);
    EXPECT_NEAR(std::sqrt(update.covariance->coeff(0, 0)) / slip_m, 1.0, 0.1) << frame.index;
  }
  EXPECT_GT(submaps, 5U);
}

}  // namespace
}  // namespace rastro
