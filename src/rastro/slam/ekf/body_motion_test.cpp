// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/body_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace rastro {
namespace {

using Kind = LandmarkAssociation::Kind;

const std::vector<LandmarkAssociation> none;
const std::vector<LandmarkAssociation> fit{{Kind::landmark, 0, 3.0}, {Kind::landmark, 1, 2.0}};

Frame frame_at(double seconds) {
  Frame frame;
  frame.stamp = static_cast<TimeNs>(std::llround(1e9 * seconds));
  return frame;
}

/// Of (x, y, angle) after so many seconds without odometry; a landmark is recognized in every so many frames, 0: never.
Eigen::Matrix3d uncertainty_after(double seconds, double period, int recognized_every = 0) {
  BodyMotion motion{EkfOptions()};
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  const int frames = static_cast<int>(std::lround(seconds / period));
  for (int k = 0; k <= frames; ++k) {
    Frame frame = frame_at(period * k);
    if (k == 0) frame.odometry_from_body = SE2();
    SlamUpdate update;
    sum += motion.since_last(frame, update).covariance;
    const bool recognized = recognized_every > 0 && k % recognized_every == 0;
    motion.end_frame(frame, recognized ? fit : none, SE2(), recognized);
  }
  return sum;
}

TEST(BodyMotion, WithoutOdometryItDoesNotDependOnTheNumberOfFrames) {
  const double angle = 30.0 * std::numbers::pi / 180.0;
  for (const double period : {0.05, 0.1, 0.5, 2.0}) {
    const Eigen::Matrix3d covariance = uncertainty_after(2.0, period);
    EXPECT_NEAR(covariance(0, 0), 0.25 * 2.0 * 2.0, 1e-9) << period;
    EXPECT_NEAR(covariance(1, 1), 0.25 * 2.0 * 2.0, 1e-9) << period;
    EXPECT_NEAR(covariance(2, 2), angle * angle * 2.0 * 2.0, 1e-9) << period;
  }
  EXPECT_NEAR(uncertainty_after(60.0, 0.5)(0, 0), 0.25 * 10.0 * 60.0, 1e-6) << "an error lasts for ten seconds";
  EXPECT_NEAR(uncertainty_after(60.0, 0.5)(2, 2), 4.0, 1e-9) << "more than all round cannot be unknown";
}

TEST(BodyMotion, ALandmarkTellsTheMotionUpToThere) {
  EXPECT_NEAR(uncertainty_after(2.0, 0.1, 1)(0, 0), 20 * 0.25 * 0.1 * 0.1, 1e-9);
  EXPECT_NEAR(uncertainty_after(2.0, 0.1, 5)(0, 0), 4 * 0.25 * 0.5 * 0.5, 1e-9);
}

/// Wheels whose messages are missing from frame 10 on, and a scan that shows motion; landmarks are recognized up to
/// frame 15.
Frame frozen_frame(int k) {
  Frame frame = frame_at(0.1 * k);
  frame.odometry_from_body = SE2(SO2(), {0.05 * std::min(k, 9), 0.0});
  frame.scan.emplace();
  frame.scan->max_range = 20.0;
  frame.scan->ranges.assign(100, 5.0F - 0.05F * static_cast<float>(std::max(0, k - 9)));
  return frame;
}

TEST(BodyMotion, WhileOdometryIsFrozenNoTimeCountsTwice) {
  BodyMotion motion{EkfOptions()};
  double told = 0.0;
  for (int k = 0; k <= 22; ++k) {
    SlamUpdate update;
    const Frame frame = frozen_frame(k);
    const std::vector<LandmarkAssociation>& seen = k <= 15 ? fit : none;
    motion.since_last(frame, update);
    EXPECT_EQ(motion.is_frozen(seen, update), k >= 16) << k;
    EXPECT_EQ(motion.lost(), k == 22) << k;
    if (motion.frozen() && !motion.lost()) told += motion.unknown().covariance(0, 0);
    if (k == 22) continue;
    motion.end_frame(frame, seen, SE2(), k <= 15);
  }
  EXPECT_NEAR(told, 0.25 * 0.6 * 0.6, 1e-9);
  EXPECT_NEAR(told + motion.unknown_covariance()(0, 0), 0.25 * 0.7 * 0.7, 1e-9);
}

TEST(BodyMotion, WhatFrozenOdometryMissedComesWithTheNextStep) {
  BodyMotion motion{EkfOptions()};
  Motion last;
  for (int k = 0; k <= 21; ++k) {
    SlamUpdate update;
    Frame frame = frozen_frame(k);
    if (k >= 20) frame.odometry_from_body = SE2(SO2(), {0.05 * k, 0.0});
    const std::vector<LandmarkAssociation>& seen = k <= 15 ? fit : none;
    last = motion.since_last(frame, update);
    EXPECT_EQ(motion.is_frozen(seen, update), k >= 16 && k <= 20) << k;
    motion.end_frame(frame, seen, SE2(), k <= 15);
  }
  EXPECT_NEAR(last.last_from_body.translation().x(), 0.05, 1e-9);
  EXPECT_NEAR(last.covariance(0, 0), 0.25 * 0.5 * 0.5 + 0.02 * 0.02 * 0.05, 1e-9) << "of frames 16 to 20";
}

}  // namespace
}  // namespace rastro
