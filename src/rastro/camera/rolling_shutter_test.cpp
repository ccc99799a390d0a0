// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/rolling_shutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/camera/calibration_file.h"
#include "rastro/math/so3.h"

namespace rastro {
namespace {

Camera rolling(double readout_s) {
  Camera camera = *published_tum_camera("freiburg1");
  camera.readout_s = readout_s;
  return camera;
}

/// Where a rotating camera sees a direction: in the row that it reads at that instant.
Eigen::Vector2d seen(const Camera& camera, const Eigen::Vector3d& at_middle, const Eigen::Vector3d& angular_velocity) {
  Eigen::Vector2d pixel = *camera.project(at_middle);
  for (int k = 0; k < 100; ++k) {
    const double t = (pixel.y() / (camera.height - 1) - 0.5) * camera.readout_s;
    pixel = *camera.project(SO3::exp(t * angular_velocity) * at_middle);
  }
  return pixel;
}

TEST(RollingShutter, PixelsMoveToWhereTheMiddleRowIsRead) {
  const Camera camera = rolling(0.03);
  Random random(1);
  double largest = 0.0;
  for (int k = 0; k < 500; ++k) {
    const Eigen::Vector3d direction(random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3), 1.0);
    const Eigen::Vector3d velocity(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
    const Eigen::Vector2d recorded = seen(camera, direction, velocity), middle = *camera.project(direction);
    const PixelAtMiddleRow moved = at_middle_row(camera, recorded, velocity);
    EXPECT_LT((moved.pixel - middle).norm(), 1e-3);
    const double t = (recorded.y() / (camera.height - 1) - 0.5) * camera.readout_s;
    EXPECT_NEAR(moved.depth_factor * (SO3::exp(t * velocity) * direction).z(), direction.z(), 1e-4);
    largest = std::max(largest, (recorded - middle).norm());
  }
  EXPECT_GT(largest, 10.0) << "a hundred degrees a second matter";
}

TEST(RollingShutter, NothingMovesWithoutRotationOrWithAGlobalShutter) {
  const Eigen::Vector2d pixel(100.0, 400.0);
  EXPECT_LT((at_middle_row(rolling(0.03), pixel, Eigen::Vector3d::Zero()).pixel - pixel).norm(), 1e-6);
  EXPECT_EQ(at_middle_row(rolling(0.0), pixel, {1.0, 2.0, 0.5}).pixel, pixel);
}

}  // namespace
}  // namespace rastro
