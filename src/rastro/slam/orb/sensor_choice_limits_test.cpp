// SPDX-License-Identifier: Apache-2.0
// What a calibration must hold, how far depths are read, and what of a frame is kept.
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/slam/orb/sensor_choice.h"
#include "rastro/slam/orb/tracking/wall_testing.h"

namespace rastro {
namespace {

using testing::image_of_wall;
using testing::wall_m;

Camera small_pinhole() {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 230.0;
  camera.cx = 160.0;
  camera.cy = 120.0;
  return camera;
}

SourceInfo small_pair(const Camera& camera, const SE3& left_from_right) {
  SourceInfo source;
  source.path = "pair";
  source.cameras = {{"left", camera, {}, ""}, {"right", camera, {}, ""}};
  source.left_from_right = left_from_right;
  source.has_right = true;
  return source;
}

OrbSlamOptions options_for_sensor(const char* sensor) {
  OrbSlamOptions options;
  options.sensor = sensor;
  options.features = 300;
  return options;
}

TEST(SensorChoice, APairNeedsBothCamerasAndTheirBaseline) {
  const SE3 aside(SO3(), {0.3, 0.0, 0.0});
  SourceInfo one = small_pair(small_pinhole(), aside), unknown = one, apart = one;
  one.cameras.pop_back();
  unknown.cameras[1].camera.reset();
  apart.left_from_right.reset();
  for (const SourceInfo& source : {one, unknown, apart}) {
    const SensorChoice choice = choose_sensor(options_for_sensor("auto"), source);
    EXPECT_EQ(choice.sensor, CameraKind::mono);
    EXPECT_EQ(choice.baseline, 0.0);
    EXPECT_FALSE(choice.rectification);
    EXPECT_EQ(choice.camera.fx, small_pinhole().fx);
  }
}

TEST(SensorChoice, ARectifiedPairHasTheCameraAndBaselineOfItsRectification) {
  Camera camera = small_pinhole();
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-0.2, 0.05, 0.0, 0.0, 0.0};
  const SE3 turned(SO3::exp({0.02, -0.03, 0.015}), {0.3, 0.003, -0.004});
  const SensorChoice choice = choose_sensor(options_for_sensor("stereo"), small_pair(camera, turned));
  ASSERT_TRUE(choice.rectification);
  EXPECT_EQ(choice.baseline, choice.rectification->baseline);
  EXPECT_NEAR(choice.baseline, turned.translation().norm(), 1e-9);
  EXPECT_EQ(choice.camera.fx, choice.rectification->camera.fx);
  EXPECT_EQ(choice.camera.distortion, Distortion::none);
  // The right camera lies along the x axis of what is rectified.
  const Eigen::Vector3d along = choice.camera_from_left().rotation() * turned.translation();
  EXPECT_LT((along - Eigen::Vector3d(choice.baseline, 0.0, 0.0)).norm(), 1e-6);
  EXPECT_EQ(choice.camera_from_left().translation(), Eigen::Vector3d::Zero());
}

TEST(FrameRectifier, KeepsWhatAFrameIsAndRemapsBothImages) {
  Camera camera = small_pinhole();
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-0.2, 0.05, 0.0, 0.0, 0.0};
  const SE3 turned(SO3::exp({0.02, -0.03, 0.015}), {0.3, 0.003, -0.004});
  const SensorChoice choice = choose_sensor(options_for_sensor("stereo"), small_pair(camera, turned));
  ASSERT_TRUE(choice.rectification);
  Frame frame;
  frame.index = 17;
  frame.stamp = 123456;
  frame.name = "the one";
  frame.image = image_of_wall(camera, SE3());
  const FrameRectifier rectifier(choice.rectification, nullptr);
  EXPECT_TRUE(rectifier.rectified(frame).right.empty());
  frame.right = image_of_wall(camera, turned);
  const Frame rectified = rectifier.rectified(frame);
  EXPECT_EQ(rectified.index, 17);
  EXPECT_EQ(rectified.stamp, 123456);
  EXPECT_EQ(rectified.name, "the one");
  const GrayImage left = remap(frame.image.view(), choice.rectification->left, nullptr);
  const GrayImage right = remap(frame.right.view(), choice.rectification->right, nullptr);
  for (int y = 0; y < left.height(); ++y) {
    for (int x = 0; x < left.width(); ++x) {
      ASSERT_EQ(rectified.image.at(x, y), left.at(x, y));
      ASSERT_EQ(rectified.right.at(x, y), right.at(x, y));
    }
  }
  for (GrayImage Frame::*image : {&Frame::image, &Frame::right}) {
    for (const auto& [width, height] : {std::pair{319, 240}, {320, 239}}) {
      Frame other = frame;
      other.*image = GrayImage(width, height);
      EXPECT_THROW(rectifier.rectified(other), Error) << width << ' ' << height;
    }
  }
}

TEST(FeatureMaker, DepthsAreReadUpToTwentyMeters) {
  const Camera camera = small_pinhole();
  SourceInfo source;
  source.cameras = {{"rgb", camera, {}, ""}};
  source.has_depth = true;
  const OrbSlamOptions options = options_for_sensor("rgbd");
  const SensorChoice choice = choose_sensor(options, source);
  FeatureMaker maker(options, choice, nullptr);
  Frame frame;
  frame.index = 5;
  frame.stamp = 77;
  frame.image = image_of_wall(camera, SE3());
  for (const float depth : {0.0F, 19.9F, 20.1F}) {
    if (depth > 0.0F) {
      frame.depth = DepthImage(camera.width, camera.height);
      for (int y = 0; y < camera.height; ++y) std::fill_n(frame.depth.row(y), camera.width, depth);
    }
    const auto features = maker.make(frame);
    EXPECT_EQ(features->data().frame, 5);
    EXPECT_EQ(features->data().stamp, 77);
    ASSERT_GT(features->size(), 100U);
    ASSERT_EQ(features->data().depths.size(), features->size());
    for (const float read : features->data().depths) EXPECT_NEAR(read, depth < 20.0F ? depth : 0.0F, 1e-3F) << depth;
  }
}

TEST(FeatureMaker, WithoutARightImageAPairKnowsNoDepths) {
  const Camera camera = small_pinhole();
  const OrbSlamOptions options = options_for_sensor("stereo");
  const SensorChoice choice = choose_sensor(options, small_pair(camera, SE3(SO3(), {0.3, 0.0, 0.0})));
  Frame frame;
  frame.image = image_of_wall(camera, SE3());
  FeatureMaker maker(options, choice, nullptr);
  const auto alone = maker.make(frame);
  ASSERT_GT(alone->size(), 100U);
  EXPECT_EQ(alone->data().depths, std::vector<float>(alone->size(), 0.0F));
  EXPECT_EQ(alone->data().right_x, std::vector<float>(alone->size(), -1.0F));
  frame.right = image_of_wall(camera, SE3(SO3(), {0.3, 0.0, 0.0}));
  const auto both = maker.make(frame);
  int known = 0, exact = 0;
  for (std::size_t i = 0; i < both->size(); ++i) {
    const double depth = static_cast<double>(both->data().depths[i]);
    if (!(depth > 0.0)) continue;
    ++known;
    exact += std::abs(depth - wall_m) < 0.03 * wall_m ? 1 : 0;
    const double disparity = static_cast<double>(both->data().features.keypoints[i].x - both->data().right_x[i]);
    EXPECT_NEAR(depth, camera.fx * 0.3 / disparity, 1e-3 * depth);
  }
  EXPECT_GT(known, 60);
  EXPECT_GT(exact, known * 9 / 10);
}

}  // namespace
}  // namespace rastro
