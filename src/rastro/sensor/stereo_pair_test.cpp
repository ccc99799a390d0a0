// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/stereo_pair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"

namespace rastro {
namespace {

GrayImage plain_image(int width, int height, std::uint8_t value = 90) {
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y) std::fill_n(image.row(y), width, value);
  return image;
}

constexpr double baseline = 0.11;

Camera pinhole() {
  Camera camera;
  camera.width = 160, camera.height = 120;
  camera.fx = camera.fy = 130.0, camera.cx = 79.5, camera.cy = 59.5;
  return camera;
}

SourceInfo pair_of(const SE3& left_from_right) {
  SourceInfo source;
  for (int side = 0; side < 2; ++side) {
    CalibratedCamera camera;
    camera.camera = pinhole();
    source.cameras.push_back(camera);
  }
  source.left_from_right = left_from_right;
  return source;
}

SE3 side_by_side() { return {SO3(), {baseline, 0.0, 0.0}}; }

/// The second camera a little turned and raised.
SE3 askew() { return {SO3::exp({0.02, 0.03, -0.05}), {baseline, 0.004, -0.006}}; }

TEST(StereoPair, ARectifiedPairStaysAsItIs) {
  const auto pair = stereo_pair(pair_of(side_by_side()));
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->rectification, nullptr);
  EXPECT_EQ(pair->camera.fx, 130.0);
  EXPECT_EQ(pair->baseline, baseline);
  EXPECT_EQ(pair->camera_from_left().log().norm(), 0.0);
}

TEST(StereoPair, WhatIsNotARectifiedPairIsRectified) {
  SourceInfo distorted = pair_of(side_by_side()), zoomed = distorted, lower = pair_of({SO3(), {baseline, 0.002, 0.0}});
  distorted.cameras[1].camera->distortion = Distortion::radial_tangential;
  distorted.cameras[1].camera->coefficients[0] = 0.05;
  zoomed.cameras[1].camera->fx += 1.0;
  for (const SourceInfo& source : {distorted, zoomed, lower, pair_of(askew())}) {
    const auto pair = stereo_pair(source);
    ASSERT_TRUE(pair);
    ASSERT_NE(pair->rectification, nullptr);
    EXPECT_NEAR(pair->baseline, source.left_from_right->translation().norm(), 1e-12);
  }
}

/// A point goes to the same row of both images, with the disparity of its depth.
TEST(StereoPair, RectifiedRowsCorrespond) {
  const auto pair = stereo_pair(pair_of(askew()));
  ASSERT_TRUE(pair && pair->rectification);
  const SE3 rectified_from_left = pair->camera_from_left();
  const SE3 rectified_from_right(rectified_from_left.rotation(), rectified_from_left * askew().translation());
  EXPECT_NEAR((rectified_from_right.translation() - Eigen::Vector3d(pair->baseline, 0, 0)).norm(), 0.0, 1e-9);
  const auto spot_in = [&](const Eigen::Vector3d& point, const SE3& camera_from_left) {
    Frame frame;
    frame.image = frame.right = GrayImage(160, 120);
    const auto draw = [&](GrayImage& image, const Eigen::Vector3d& seen) {
      const double u = 130.0 * seen.x() / seen.z() + 79.5, v = 130.0 * seen.y() / seen.z() + 59.5;
      for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x)
          image.at(x, y) =
              static_cast<std::uint8_t>(20.0 + 230.0 * std::exp(-0.5 * ((x - u) * (x - u) + (y - v) * (y - v)) / 4.0));
    };
    draw(frame.image, point);
    draw(frame.right, camera_from_left * point);
    return frame;
  };
  const auto center_of = [](const GrayImage& image) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        if (image.at(x, y) > 40) sum += (image.at(x, y) - 20.0) * Eigen::Vector3d(x, y, 1.0);
    return Eigen::Vector2d(sum.head<2>() / sum.z());
  };
  const FrameRectifier rectifier(pair->rectification, nullptr);
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.2, 0.1, 1.2), {-0.1, -0.3, 1.5}, {0.0, 0.2, 0.9}}) {
    const Frame seen = rectifier.rectified(spot_in(point, askew().inverse()));
    const Eigen::Vector2d left = center_of(seen.image), right = center_of(seen.right);
    const double depth = (rectified_from_left * point).z();
    EXPECT_NEAR(left.y(), right.y(), 0.1);
    EXPECT_NEAR(left.x() - right.x(), pair->camera.fx * pair->baseline / depth, 0.15);
  }
}

TEST(StereoPair, WithoutCalibrationOrSideBySideThereIsNone) {
  EXPECT_TRUE(has_calibrated_pair(pair_of(side_by_side())));
  SourceInfo one = pair_of(side_by_side()), uncalibrated = one, unplaced = one;
  one.cameras.pop_back();
  uncalibrated.cameras[1].camera.reset();
  unplaced.left_from_right.reset();
  for (const SourceInfo& source : {one, uncalibrated, unplaced}) {
    EXPECT_FALSE(has_calibrated_pair(source));
    EXPECT_FALSE(stereo_pair(source));
  }
  EXPECT_FALSE(stereo_pair(pair_of({SO3(), {0.0, 0.0, baseline}}))) << "one behind the other";
  EXPECT_FALSE(stereo_pair(pair_of({SO3(), {-baseline, 0.0, 0.0}}))) << "exchanged";
  SourceInfo sizes = pair_of(askew());
  sizes.cameras[1].camera->width = 200;
  EXPECT_FALSE(stereo_pair(sizes));
}

TEST(FrameRectifier, ImagesOfAnotherSizeThanTheCalibrationAreRefused) {
  const auto pair = stereo_pair(pair_of(askew()));
  const FrameRectifier rectifier(pair->rectification, nullptr);
  Frame frame;
  frame.index = 7;
  frame.image = frame.right = plain_image(160, 120);
  EXPECT_EQ(rectifier.rectified(frame).index, 7);
  frame.right = plain_image(160, 121);
  EXPECT_THROW(rectifier.rectified(frame), Error);
  frame.right = {};
  EXPECT_TRUE(rectifier.rectified(frame).right.empty());
  frame.image = plain_image(161, 120);
  EXPECT_THROW(rectifier.rectified(frame), Error);
}

TEST(StereoPair, WithoutAPairAWarningOrAnError) {
  SourceInfo source = pair_of({SO3(), {0.0, 0.0, baseline}});
  source.path = "walk";
  std::vector<std::string> said;
  set_log_sink([&](LogLevel, const std::string& line) { said.push_back(line); });
  EXPECT_FALSE(choose_stereo_pair(source, false));
  source.left_from_right.reset();
  EXPECT_FALSE(choose_stereo_pair(source, false));
  set_log_sink({});
  ASSERT_EQ(said.size(), 2);
  EXPECT_NE(said[0].find("walk has stereo images of cameras that are not side by side"), std::string::npos);
  EXPECT_NE(said[1].find("without calibration"), std::string::npos);
  EXPECT_THROW(choose_stereo_pair(source, true), Error);
  EXPECT_TRUE(choose_stereo_pair(pair_of(side_by_side()), true));
}

TEST(FrameRectifier, TheMaskOfTheRecordingAndTheBorderAreMasked) {
  const auto pair = stereo_pair(pair_of(askew()));
  const FrameRectifier rectifier(pair->rectification, nullptr);
  Frame frame;
  frame.image = plain_image(160, 120);
  const GrayImage shown = rectifier.rectified(frame).mask;
  EXPECT_EQ(shown.at(0, 0), 0);
  EXPECT_NE(shown.at(80, 60), 0);
  frame.mask = plain_image(160, 120, 255);
  for (int y = 40; y < 80; ++y) std::fill_n(frame.mask.row(y) + 60, 40, std::uint8_t{0});
  const GrayImage both = rectifier.rectified(frame).mask;
  EXPECT_EQ(both.at(0, 0), 0);
  EXPECT_EQ(both.at(80, 60), 0);
  EXPECT_NE(both.at(80, 95), 0);
}

}  // namespace
}  // namespace rastro
