// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/feature_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

Camera skewed_camera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500.0;
  camera.fy = 400.0;
  camera.cx = 310.0;
  camera.cy = 250.0;
  return camera;
}

/// Three features, of which the first two have depths: 4 m and none.
FeatureFrame three_features(double baseline) {
  auto data = std::make_shared<ImageFeatures>();
  data->id = 7;
  data->features.keypoints = {{410.0F, 290.0F, 31, 0, 1}, {300.0F, 200.0F, 31, 0, 1}, {10.0F, 20.0F, 31, 0, 1}};
  data->features.levels = {0, 1, 2};
  data->features.descriptors.resize(3);
  data->depths = {4.0F, 0.0F};
  return {data, skewed_camera(), baseline};
}

TEST(FeatureFrame, AFeatureWithDepthIsAtAPointAndAtAPixelOfTheRightCamera) {
  const FeatureFrame frame = three_features(0.2);
  EXPECT_EQ(frame.size(), 3U);
  EXPECT_NEAR((frame.ray(0) - Eigen::Vector2d(0.2, 0.1)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((frame.point(0) - Eigen::Vector3d(0.8, 0.4, 4.0)).norm(), 0.0, 1e-5);
  EXPECT_NEAR(frame.right_pixel(0), 410.0 - 500.0 * 0.2 / 4.0, 1e-4);
  EXPECT_NEAR(frame.right_ray(0), 0.2 - 0.2 / 4.0, 1e-6);
  for (const std::size_t without : {1U, 2U}) EXPECT_TRUE(std::isnan(frame.right_pixel(without))) << without;
  EXPECT_TRUE(std::isnan(three_features(0.0).right_pixel(0))) << "without a baseline there is no right camera";
}

TEST(FeatureFrame, ACopyWithAnotherIdIsTheSameOtherwise) {
  const FeatureFrame frame = three_features(0.2);
  const auto copy = frame.with_id(12);
  EXPECT_EQ(copy->data().id, 12);
  EXPECT_EQ(frame.data().id, 7);
  ASSERT_EQ(copy->size(), 3U);
  EXPECT_EQ(copy->pixel(0), frame.pixel(0));
  EXPECT_EQ(copy->right_pixel(0), frame.right_pixel(0));
  EXPECT_EQ(copy->level(2), 2);
}

}  // namespace
}  // namespace rastro
