// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/ekf_slam.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstring>

#include "rastro/slam/ekf/ekf_testing.h"

namespace rastro {
namespace {

using testing::LandmarkDrive;
using testing::LandmarkWorld;
using testing::ring_world;

double nees_of(const SlamUpdate& update, const SE2& truth) {
  const SE2 pose = {SO2::from_angle(update.world_from_body.rotation().log().z()),
                    update.world_from_body.translation().head<2>()};
  Eigen::Vector3d error;
  error << pose.translation() - truth.translation(), (truth.rotation().inverse() * pose.rotation()).angle();
  Eigen::Matrix3d covariance;
  constexpr int planar[3] = {0, 1, 5};
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) covariance(a, b) = (*update.covariance)(planar[a], planar[b]);
  }
  return error.dot(covariance.inverse() * error);
}

struct Consistency {
  double share_inside = 0.0;  ///< Of the steps.
  double mean = 0.0;          ///< Of NEES over runs and steps; 3 when consistent.
};

/// The mean NEES of 50 runs must lie in [2.36, 3.72] at 95 % of the steps: chi-square of 150 degrees of freedom has 95
/// % between 117.98 and 185.80 (Bar-Shalom, Li and Kirubarajan 2001, 5.4.2).
Consistency consistency_of(const LandmarkWorld& world, const EkfOptions& options, int steps) {
  constexpr int runs = 50;
  std::vector<double> sums(static_cast<std::size_t>(steps), 0.0);
  for (int run = 0; run < runs; ++run) {
    LandmarkDrive drive(world, options, static_cast<std::uint64_t>(run) + 1);
    EkfSlam slam(options, false);
    slam.process(drive.next());
    for (double& sum : sums) {
      const SlamUpdate update = slam.process(drive.next());
      sum += nees_of(update, drive.world_from_body());
    }
  }
  Consistency result;
  for (const double sum : sums) {
    const double mean = sum / runs;
    result.mean += mean / steps;
    if (mean >= 117.98 / runs && mean <= 185.80 / runs) result.share_inside += 1.0 / steps;
  }
  return result;
}

TEST(EkfSlam, IsAsSureAsItMayBeOverFiftyRuns) {
  const Consistency found = consistency_of(ring_world(20, 5), EkfOptions(), 250);
  RecordProperty("share_inside", std::to_string(found.share_inside));
  RecordProperty("mean", std::to_string(found.mean));
  printf("%f %f\n", found.share_inside, found.mean);
  EXPECT_GE(found.share_inside, 0.85);
  EXPECT_GT(found.mean, 2.36);
  EXPECT_LT(found.mean, 3.72);
}

}  // namespace
}  // namespace rastro
