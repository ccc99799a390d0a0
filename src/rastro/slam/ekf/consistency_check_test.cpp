// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/consistency_check.h"

#include <gtest/gtest.h>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// After 30 m along which odometry has `noise` times the errors of the settings and landmarks tell the motion exactly;
/// at `jump_at` the filter recognizes a place.
double factor_after(double noise, bool told, int jump_at = -1) {
  ConsistencyCheck check;
  Random random(3);
  SE2 world_from_body;
  const SE2 motion(SO2(), {0.1, 0.0});
  for (int k = 0; k <= 300; ++k) {
    Motion by_odometry = measured_motion(motion, EkfOptions());
    const Eigen::Vector3d sigma = noise * by_odometry.covariance.diagonal().cwiseSqrt();
    by_odometry.last_from_body = SE2(SO2::from_angle(sigma.z() * random.normal()),
                                     {0.1 + sigma.x() * random.normal(), sigma.y() * random.normal()});
    check.move(by_odometry);
    world_from_body = world_from_body * motion;
    if (k == jump_at) world_from_body = SE2(SO2::from_angle(0.3), {2.0, -3.0}) * world_from_body;
    check.end_frame(world_from_body, told);
  }
  return check.factor();
}

TEST(ConsistencyCheck, OdometryAsSetIsConsistent) {
  EXPECT_EQ(factor_after(1.0, true), 1.0);
  EXPECT_EQ(factor_after(1.5, true), 1.0);
}

TEST(ConsistencyCheck, TellsByWhatErrorsAreLargerThanSet) {
  for (const double noise : {6.0, 20.0}) {
    const double factor = factor_after(noise, true);
    EXPECT_GT(factor, 0.8 * noise);
    EXPECT_LT(factor, 2.0 * noise) << "the largest estimate counts, of eight stretches or more";
  }
}

TEST(ConsistencyCheck, APlaceThatIsRecognizedIsNoContradiction) { EXPECT_EQ(factor_after(1.0, true, 155), 1.0); }

TEST(ConsistencyCheck, WithoutLandmarksThereIsNothingToCompare) { EXPECT_EQ(factor_after(20.0, false), 1.0); }

}  // namespace
}  // namespace rastro
