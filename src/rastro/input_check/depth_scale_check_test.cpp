// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/depth_scale_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace rastro {
namespace {

constexpr double kinect_k = 0.125 / (525.0 * 0.075);

/// A slope from 1 to 3 m.
DepthImage slope(const std::function<double(double)>& measured) {
  DepthImage depth(640, 480);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) depth.at(x, y) = static_cast<float>(measured(1.0 + (480.0 * x + y) / 153600.0));
  return depth;
}

/// In whole disparities, then in whole millimeters.
double kinect(double z) { return std::round(1000.0 / (kinect_k * std::round(1.0 / (kinect_k * z)))) / 1000.0; }

InputWarnings warnings(const DepthImage& depth, const Camera& camera) {
  DepthScaleCheck check(camera);
  InputWarnings found;
  Frame frame;
  frame.depth = depth;
  for (int k = 0; k < 60; ++k) check.add(frame, found);
  return found;
}

Camera kinect_camera() {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 525.0;
  camera.cx = 319.5, camera.cy = 239.5;
  return camera;
}

TEST(DepthSteps, AreThoseOfTheDisparities) {
  const auto k = depth_steps(slope(kinect));
  ASSERT_TRUE(k);
  EXPECT_NEAR(*k, kinect_k, 0.03 * kinect_k);
  EXPECT_NEAR(depth_steps(slope([](double z) { return 2.0 * kinect(z); })).value_or(0.0), 0.5 * kinect_k,
              0.03 * kinect_k);
}

TEST(DepthSteps, ThoseOfTheFileAreNone) {
  EXPECT_FALSE(depth_steps(slope([](double z) { return z; })));
  EXPECT_FALSE(depth_steps(slope([](double z) { return std::round(1000.0 * z) / 1000.0; })));
  EXPECT_FALSE(depth_steps(slope([](double) { return 2.0; })));
  EXPECT_FALSE(depth_steps(DepthImage()));
}

TEST(DepthScaleCheck, TellsAWrongDepthFactorOfAKinect) {
  for (const double factor : {0.2, 0.5, 2.0, 5.0}) {
    const InputWarnings found = warnings(slope([&](double z) { return factor * kinect(z); }), kinect_camera());
    ASSERT_EQ(found.size(), 1U) << factor;
    EXPECT_EQ(found.front().kind, "depth_scale");
  }
}

TEST(DepthScaleCheck, SaysNothingOfRightDepthsNorOfOtherCameras) {
  EXPECT_TRUE(warnings(slope(kinect), kinect_camera()).empty());
  EXPECT_TRUE(warnings(slope([](double z) { return z; }), kinect_camera()).empty());
  Camera wider = kinect_camera();
  wider.fx = wider.fy = 385.0;
  EXPECT_TRUE(warnings(slope([](double z) { return 2.0 * kinect(z); }), wider).empty());
}

}  // namespace
}  // namespace rastro
