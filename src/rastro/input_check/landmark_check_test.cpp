// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/landmark_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace rastro {
namespace {

/// Of a drive in a curve of 8 m radius past landmarks, with noisy ranges; odometry counts `wheels` times the motion.
std::string told(double ranges, double wheels, double noise_m, std::int64_t first_id = 1) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, noise_m);
  LandmarkCheck check;
  InputWarnings found;
  SE2 world_from_body, odometry;
  for (int k = 0; k < 300; ++k) {
    world_from_body = world_from_body * SE2::exp(SE2::Tangent(0.1, 0.0, 0.0125));
    odometry = odometry * SE2::exp(SE2::Tangent(0.1 * wheels, 0.0, 0.0125));
    Frame frame;
    frame.index = k;
    frame.odometry_from_body = odometry;
    for (int i = 0; i < 12; ++i) {
      const Eigen::Vector2d landmark(12.0 * std::cos(0.55 * i), 8.0 + 12.0 * std::sin(0.55 * i));
      const Eigen::Vector2d in_body = world_from_body.inverse() * landmark;
      if (in_body.norm() > 7.0) continue;
      frame.landmarks.push_back({first_id < 0 ? -1 : first_id + i, ranges * in_body.norm() + noise(random),
                                 std::atan2(in_body.y(), in_body.x())});
    }
    check.add(frame, found);
  }
  return found.empty() ? "" : found.front().kind;
}

TEST(LandmarkCheck, RightInputIsLeftAlone) {
  for (const double wheels : {0.85, 1.0, 1.15}) EXPECT_EQ(told(1.0, wheels, 0.05), "") << wheels;
  EXPECT_EQ(told(1.0, 1.0, 0.2), "") << "noisy";
}

TEST(LandmarkCheck, TellsRangesAndOdometryInDifferentUnits) {
  for (const double factor : {0.3048, 0.5, 0.7, 1.5, 2.0, 3.28}) {
    EXPECT_EQ(told(factor, 1.0, 0.05), "landmark_scale") << factor;
    EXPECT_EQ(told(1.0, 1.0 / factor, 0.05), "landmark_scale") << factor;
  }
  EXPECT_EQ(told(1.0, -1.0, 0.05), "landmark_scale") << "backward";
}

TEST(LandmarkCheck, WithoutIdsNothingIsKnown) { EXPECT_EQ(told(0.5, 1.0, 0.05, -1), ""); }

}  // namespace
}  // namespace rastro
