// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth_measurement.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

LsdSensor depth_sensor() {
  Camera camera;
  camera.width = 64, camera.height = 48;
  camera.fx = camera.fy = 60.0, camera.cx = 31.5, camera.cy = 23.5;
  LsdSensor sensor = single_camera(camera);
  sensor.kind = CameraKind::depth;
  return sensor;
}

/// 2 m on the left, 3 m on the right.
DepthImage step_of_depth() {
  DepthImage depth(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) depth.at(x, y) = x < 32 ? 2.0F : 3.0F;
  return depth;
}

TEST(DepthCameraMeasurement, ReadsDepthsWithTheNoiseOfTheCameraButNoneAtEdges) {
  const LsdSensor sensor = depth_sensor();
  const DepthImage depth = step_of_depth();
  const LsdOptions options;
  const DepthCameraMeasurement measurement(depth, SE3(), sensor, options);
  const EpipolarMatch near = measurement.find(10, 20), far = measurement.find(50, 20);
  ASSERT_EQ(near.result, EpipolarResult::matched);
  ASSERT_EQ(far.result, EpipolarResult::matched);
  EXPECT_NEAR(near.mean, 0.5, 1e-5);
  EXPECT_NEAR(far.mean, 1.0 / 3.0, 1e-5);
  const double sigma_m = std::sqrt(static_cast<double>(near.variance)) * 2.0 * 2.0;
  EXPECT_NEAR(sigma_m, options.depth_sigma_m + options.depth_sigma_per_m2 * 4.0, 1e-6);
  EXPECT_EQ(measurement.find(32, 20).result, EpipolarResult::outside);
}

/// A box of 20 cm before a wall: at its edge the mean of the window would be too far by 5 %.
TEST(DepthCameraMeasurement, ReadsNoneAtLowSteps) {
  const LsdSensor sensor = depth_sensor();
  DepthImage depth(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) depth.at(x, y) = x < 32 ? 2.0F : 2.2F;
  LsdOptions options;
  const DepthCameraMeasurement measurement(depth, SE3(), sensor, options);
  for (const int x : {31, 32}) EXPECT_EQ(measurement.find(x, 20).result, EpipolarResult::outside) << x;
  for (const int x : {29, 34}) EXPECT_EQ(measurement.find(x, 20).result, EpipolarResult::matched) << x;
  options.depth_edge_sigmas = 4.0;
  EXPECT_EQ(DepthCameraMeasurement(depth, SE3(), sensor, options).find(32, 20).result, EpipolarResult::matched);
}

TEST(DepthCameraMeasurement, DepthsOfAnotherInstantAreMovedToThatOfTheImage) {
  const LsdSensor sensor = depth_sensor();
  const DepthImage depth = step_of_depth();
  const LsdOptions options;
  const DepthCameraMeasurement backwards(depth, SE3(SO3(), {0.0, 0.0, 0.1}), sensor, options);
  EXPECT_NEAR(1.0 / static_cast<double>(backwards.find(10, 20).mean), 1.9, 1e-4);
  // A rotation of 12 pixels: the depth image shows the far side where the image shows the near one.
  const DepthCameraMeasurement turned(depth, SE3(SO3::exp({0.0, 0.2, 0.0}), {}), sensor, options);
  EXPECT_GT(1.0 / static_cast<double>(turned.find(28, 20).mean), 2.7);
}

TEST(DepthCameraMeasurement, DepthsOutOfRangeAreNotUsed) {
  const LsdSensor sensor = depth_sensor();
  const DepthImage depth = step_of_depth();
  LsdOptions options;
  options.max_depth_m = 2.5;
  const DepthCameraMeasurement measurement(depth, SE3(), sensor, options);
  EXPECT_EQ(measurement.find(10, 20).result, EpipolarResult::matched);
  EXPECT_EQ(measurement.find(50, 20).result, EpipolarResult::outside);
}

}  // namespace
}  // namespace rastro
