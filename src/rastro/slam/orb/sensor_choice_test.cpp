// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/sensor_choice.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

constexpr double wall_m = 3.0;

Camera distorted() {
  Camera camera;
  camera.width = 480;
  camera.height = 360;
  camera.fx = camera.fy = 340.0;
  camera.cx = 242.0;
  camera.cy = 178.0;
  camera.distortion = Distortion::radial_tangential;
  camera.coefficients = {-0.28, 0.07, 0.0002, 0.00002, 0.0};
  return camera;
}

SE3 left_from_right() { return {SO3::exp({0.02, -0.03, 0.015}), {0.3, 0.003, -0.004}}; }

SourceInfo pair_of(const Camera& camera, const SE3& left_from_right) {
  SourceInfo source;
  source.path = "pair";
  source.cameras = {{"left", camera, {}, ""}, {"right", camera, {}, ""}};
  source.left_from_right = left_from_right;
  source.has_right = true;
  return source;
}

/// A wall `wall_m` in front of the left camera, with a texture that never repeats.
GreyImage picture_of_wall(const Camera& camera, const SE3& left_from_camera) {
  GreyImage image(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = camera.unproject({x, y});
      if (!ray) continue;
      const Eigen::Vector3d direction = left_from_camera.rotation() * Eigen::Vector3d(ray->x(), ray->y(), 1.0);
      const Eigen::Vector3d center = left_from_camera.translation();
      const Eigen::Vector3d at = center + direction * ((wall_m - center.z()) / direction.z());
      const double u = 100.0 * at.x(), v = 100.0 * at.y();
      const double wave = std::sin(0.23 * u + 0.11 * v) + std::sin(0.19 * v - 0.013 * u * std::sin(0.05 * v)) +
                          std::sin(0.31 * u - 0.0002 * u * v);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(128.0 + 40.0 * wave));
    }
  }
  return image;
}

OrbSlamOptions options_of(const char* sensor) {
  OrbSlamOptions options;
  options.sensor = sensor;
  options.features = 600;
  return options;
}

TEST(SensorChoice, APairThatIsNotRectifiedSeesDepthsAllTheSame) {
  const Camera camera = distorted();
  const OrbSlamOptions options = options_of("auto");
  const SensorChoice choice = choose_sensor(options, pair_of(camera, left_from_right()));
  ASSERT_EQ(choice.sensor, CameraKind::stereo);
  ASSERT_TRUE(choice.rectification);
  Frame frame;
  frame.image = picture_of_wall(camera, SE3());
  frame.right = picture_of_wall(camera, left_from_right());
  const Frame rectified = FrameRectifier(choice.rectification, nullptr).rectified(frame);
  const auto features = FeatureMaker(options, choice, nullptr).make(rectified, SE3());
  std::size_t known = 0, exact = 0;
  for (std::size_t i = 0; i < features->size(); ++i) {
    if (!(features->data().depths[i] > 0.0F)) continue;
    ++known;
    const Eigen::Vector3d in_left = choice.camera_from_left().inverse() * features->point(i);
    exact += std::abs(in_left.z() - wall_m) < 0.03 * wall_m ? 1U : 0U;
  }
  EXPECT_GT(known, 150U);
  EXPECT_GT(exact, known * 9 / 10);
}

TEST(SensorChoice, ARectifiedPairIsTakenAsItIs) {
  Camera camera = distorted();
  camera.distortion = Distortion::none;
  const SensorChoice choice = choose_sensor(options_of("stereo"), pair_of(camera, SE3(SO3(), {0.3, 0.0, 0.0})));
  EXPECT_EQ(choice.sensor, CameraKind::stereo);
  EXPECT_FALSE(choice.rectification);
  EXPECT_DOUBLE_EQ(choice.baseline, 0.3);
}

TEST(SensorChoice, APairThatCannotBeUsedLeavesTheLeftCameraOrIsRefused) {
  SourceInfo uncalibrated = pair_of(distorted(), left_from_right());
  uncalibrated.left_from_right.reset();
  const SourceInfo one_above_the_other = pair_of(distorted(), SE3(SO3(), {0.0, 0.3, 0.0}));
  for (const SourceInfo& source : {uncalibrated, one_above_the_other}) {
    EXPECT_EQ(choose_sensor(options_of("auto"), source).sensor, CameraKind::mono);
    EXPECT_THROW(choose_sensor(options_of("stereo"), source), Error);
  }
}

TEST(SensorChoice, MasksMoveAlong) {
  const Camera camera = distorted();
  const SensorChoice choice = choose_sensor(options_of("stereo"), pair_of(camera, left_from_right()));
  Frame frame;
  frame.image = picture_of_wall(camera, SE3());
  frame.mask = GreyImage(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) std::fill(frame.mask.row(y) + 240, frame.mask.row(y) + 480, 255);
  const FrameRectifier rectifier(choice.rectification, nullptr);
  const Frame rectified = rectifier.rectified(frame);
  EXPECT_EQ(rectified.mask.at(100, 180), 0);
  EXPECT_EQ(rectified.mask.at(380, 180), 255);
  frame.image = GreyImage(100, 100);
  EXPECT_THROW(rectifier.rectified(frame), Error);
}

}  // namespace
}  // namespace rastro
