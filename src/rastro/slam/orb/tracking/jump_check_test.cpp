// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/jump_check.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

constexpr TimeNs frame_interval = ns_per_second / 30;

SE3 camera_at(double x) { return SE3(SO3(), Eigen::Vector3d(x, 0.0, 0.0)).inverse(); }

Matrix6d covariance_of(double sigma_m) { return sigma_m * sigma_m / 3.0 * Matrix6d::Identity(); }

/// 15 m/s^2 move a camera by 1.7 cm within a frame beyond what its velocity says; errors of 1 cm by 7 more.
TEST(JumpCheck, WhatMotionAndErrorsExplainIsNone) {
  for (const auto& [moved, jump] : {std::pair(0.05, false), std::pair(0.08, false), std::pair(0.09, true)}) {
    JumpCheck check(15.0);
    EXPECT_FALSE(check.jumps(0, camera_at(5.0), camera_at(0.0), covariance_of(0.01)))
        << "nothing to compare the first with";
    EXPECT_EQ(check.jumps(frame_interval, camera_at(0.0), camera_at(moved), covariance_of(0.01)), jump) << moved;
    EXPECT_FALSE(JumpCheck(0.0).jumps(frame_interval, camera_at(0.0), camera_at(moved), covariance_of(0.01)));
  }
}

TEST(JumpCheck, AnUncertainPoseMayBeFartherOff) {
  JumpCheck check(15.0);
  check.jumps(0, camera_at(0.0), camera_at(0.0), covariance_of(0.01));
  EXPECT_FALSE(check.jumps(frame_interval, camera_at(0.0), camera_at(0.3), covariance_of(0.10)));
}

TEST(JumpCheck, AfterALossOrAGapThereIsNothingToCompare) {
  JumpCheck check(15.0);
  check.jumps(0, camera_at(0.0), camera_at(0.0), covariance_of(0.01));
  check.reset();
  EXPECT_FALSE(check.jumps(frame_interval, camera_at(0.0), camera_at(1.0), covariance_of(0.01)));
  EXPECT_FALSE(check.jumps(frame_interval + ns_per_second, camera_at(0.0), camera_at(2.0), covariance_of(0.01)));
  EXPECT_TRUE(check.jumps(2 * frame_interval + ns_per_second, camera_at(0.0), camera_at(1.0), covariance_of(0.01)));
}

}  // namespace
}  // namespace rastro
