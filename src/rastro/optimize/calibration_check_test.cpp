// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/calibration_check.h"

#include <gtest/gtest.h>

#include "rastro/base/random.h"

namespace rastro {
namespace {

/// Effect of a wrong calibration on a ray.
using Wrong = Eigen::Vector2d (*)(const Eigen::Vector2d&);
Eigen::Vector2d right(const Eigen::Vector2d& ray) { return ray; }
Eigen::Vector2d focal_too_long(const Eigen::Vector2d& ray) { return ray / 1.1; }
Eigen::Vector2d focal_too_short(const Eigen::Vector2d& ray) { return ray / 0.9; }
Eigen::Vector2d center_aside(const Eigen::Vector2d& ray) { return ray + Eigen::Vector2d(0.08, 0.0); }
Eigen::Vector2d without_distortion(const Eigen::Vector2d& ray) { return (1.0 - 0.2 * ray.squaredNorm()) * ray; }

/// Eight cameras on a trajectory, rotating or straight, and points observed by all of them with noise of 0.1 px;
/// adjusted as the odometry does.
RefinementWindow window_of(Wrong wrong, bool rotating, std::uint64_t seed) {
  Random random(seed);
  RefinementWindow window;
  for (int k = 0; k < 8; ++k) {
    const SO3 rotation = rotating ? SO3::exp({0.02 * k, 0.05 * k, 0.01 * k * k}) : SO3();
    window.camera_from_world.push_back(SE3(rotation, {rotating ? 0.3 * k : 0.0, 0.0, 0.6 * k}).inverse());
    window.fixed.push_back(k < 2 ? 1 : 0);
  }
  for (int i = 0; i < 150; ++i) {
    const int point = static_cast<int>(window.points.size());
    window.points.emplace_back(16.0 * random.uniform() - 8.0, 10.0 * random.uniform() - 5.0,
                               9.0 + 10.0 * random.uniform());
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d there = window.camera_from_world[static_cast<std::size_t>(k)] * window.points.back();
      const Eigen::Vector2d noise(random.normal(), random.normal());
      window.observations.push_back({k, point, wrong(there.head<2>() / there.z()) + 0.1 / window.focal_px * noise});
    }
  }
  refine_window(window, {20, 1.0});
  return window;
}

CalibrationCheck checked(Wrong wrong, bool rotating = true) {
  CalibrationCheck check(0.045);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) check.add(window_of(wrong, rotating, seed));
  return check;
}

TEST(CalibrationCheck, ARightCalibrationIsRight) {
  const CalibrationCheck check = checked(right);
  EXPECT_FALSE(check.doubtful());
  EXPECT_LT(check.estimate().value.cwiseAbs().maxCoeff(), 0.01);
  EXPECT_LT(check.estimate().sigma.maxCoeff(), 0.01);
}

TEST(CalibrationCheck, DetectsFocalLengthErrorsOfTenPercent) {
  const CalibrationCheck check = checked(focal_too_long), other = checked(focal_too_short);
  EXPECT_TRUE(check.doubtful());
  EXPECT_NEAR(check.estimate().value[RayCorrection::scale_x], 0.1, 0.03);
  EXPECT_NEAR(check.estimate().value[RayCorrection::scale_y], 0.1, 0.03);
  EXPECT_NE(check.detail(500.0).find("fx about 0.9"), std::string::npos) << check.detail(500.0);
  EXPECT_TRUE(other.doubtful());
  EXPECT_NEAR(other.estimate().value[RayCorrection::scale_x], -0.1, 0.03);
}

TEST(CalibrationCheck, DetectsAShiftedCenterAndMissingDistortion) {
  const CalibrationCheck shifted = checked(center_aside), distorted = checked(without_distortion);
  EXPECT_TRUE(shifted.doubtful());
  EXPECT_NE(shifted.detail(500.0).find("cx about +"), std::string::npos) << shifted.detail(500.0);
  EXPECT_TRUE(distorted.doubtful());
}

TEST(CalibrationCheck, AStraightTrajectoryDoesNotConstrainTheFocalLengthAndReportsNothing) {
  const CalibrationCheck check = checked(focal_too_long, false);
  EXPECT_FALSE(check.doubtful());
  EXPECT_GT(check.estimate().sigma[RayCorrection::scale_x], 0.05);
}

TEST(CalibrationCheck, OneWindowIsNotEnoughAndNoObservationsAreNoError) {
  CalibrationCheck check(0.045), off(0.0);
  check.add(RefinementWindow());
  EXPECT_FALSE(check.doubtful());
  check.add(window_of(focal_too_long, true, 1));
  EXPECT_FALSE(check.doubtful());
  for (std::uint64_t seed = 1; seed <= 4; ++seed) off.add(window_of(focal_too_long, true, seed));
  EXPECT_FALSE(off.doubtful());
  RefinementWindow behind = window_of(right, true, 1);
  for (Eigen::Vector3d& point : behind.points) point.z() = -5.0;
  const RayCorrection none = ray_correction(behind);
  EXPECT_TRUE(none.information.allFinite() && none.right.allFinite());
}

}  // namespace
}  // namespace rastro
