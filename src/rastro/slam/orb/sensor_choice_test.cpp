// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/sensor_choice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/odometry/rgbd_tracking/depth_reading.h"
#include "rastro/slam/orb/tracking/wall_testing.h"

namespace rastro {
namespace {

using testing::image_of_wall;
using testing::wall_m;

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

OrbSlamOptions options_of(const char* sensor) {
  OrbSlamOptions options;
  options.sensor = sensor;
  options.features = 600;
  return options;
}

TEST(SensorChoice, AMapIsContinuedWithItsOwnCamera) {
  Map map;
  map.method = "orb";
  map.layers.put<FeatureLayer>(std::make_shared<FeatureLayer>());
  map.layers.put<LandmarkLayer>(std::make_shared<LandmarkLayer>());
  map.cameras.push_back({CameraKind::mono, distorted(), 0.0, {}, SE3()});
  SensorChoice choice;
  choice.camera = distorted();
  EXPECT_NO_THROW(check_map(map, choice, true, "orb"));
  choice.camera = distorted().scaled(0.5);
  EXPECT_THROW(check_map(map, choice, true, "orb"), Error);
  EXPECT_NO_THROW(check_map(map, choice, false, "orb")) << "its landmarks are seen with any camera";
}

TEST(SensorChoice, AMapOfOneCameraIsUsedWithOneCamera) {
  const SourceInfo pair = pair_of(distorted(), left_from_right());
  Map map;
  for (const auto& [kind, sensor] : {std::pair{CameraKind::mono, "mono"}, std::pair{CameraKind::stereo, "auto"}}) {
    map.cameras = {{kind, distorted(), 0.0, {}, SE3()}};
    EXPECT_EQ(options_for(options_of("auto"), pair, &map).sensor, sensor);
    EXPECT_EQ(options_for(options_of("stereo"), pair, &map).sensor, "stereo") << "asked for";
  }
}

TEST(SensorChoice, AnUnrectifiedPairMeasuresDepthsToo) {
  const Camera camera = distorted();
  const OrbSlamOptions options = options_of("auto");
  const SensorChoice choice = choose_sensor(options, pair_of(camera, left_from_right()));
  ASSERT_EQ(choice.sensor, CameraKind::stereo);
  ASSERT_TRUE(choice.rectification);
  Frame frame;
  frame.image = image_of_wall(camera, SE3());
  frame.right = image_of_wall(camera, left_from_right());
  const Frame rectified = FrameRectifier(choice.rectification, nullptr).rectified(frame);
  const auto features = FeatureMaker(options, choice, nullptr).make(rectified);
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

TEST(SensorChoice, ARectifiedPairIsUsedUnchanged) {
  Camera camera = distorted();
  camera.distortion = Distortion::none;
  const SensorChoice choice = choose_sensor(options_of("stereo"), pair_of(camera, SE3(SO3(), {0.3, 0.0, 0.0})));
  EXPECT_EQ(choice.sensor, CameraKind::stereo);
  EXPECT_FALSE(choice.rectification);
  EXPECT_DOUBLE_EQ(choice.baseline, 0.3);
}

TEST(SensorChoice, APairIsRectifiedIfItIsNotRectifiedWellEnough) {
  Camera camera = distorted();
  camera.distortion = Distortion::none;
  const auto is_used_as_it_is = [&](const Camera& right, const SE3& left_from_right) {
    SourceInfo source = pair_of(camera, left_from_right);
    source.cameras[1].camera = right;
    const SensorChoice choice = choose_sensor(options_of("auto"), source);
    return choice.sensor == CameraKind::stereo && !choice.rectification;
  };
  const SE3 aside(SO3(), {0.3, 0.0, 0.0});
  for (double Camera::*parameter : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy}) {
    for (const double off : {-0.6, -0.4, 0.4, 0.6}) {
      Camera right = camera;
      right.*parameter += off;
      EXPECT_EQ(is_used_as_it_is(right, aside), std::abs(off) < 0.5) << off;
    }
  }
  EXPECT_FALSE(is_used_as_it_is(distorted(), aside));
  for (const double angle : {0.0009, 0.0011})
    EXPECT_EQ(is_used_as_it_is(camera, SE3(SO3::exp({0.0, angle, 0.0}), aside.translation())), angle < 0.001);
  for (const double off : {0.0014, 0.0016}) {
    EXPECT_EQ(is_used_as_it_is(camera, SE3(SO3(), {0.3, off, 0.0})), off < 0.0015);
    EXPECT_EQ(is_used_as_it_is(camera, SE3(SO3(), {0.3, 0.0, off})), off < 0.0015);
  }
  EXPECT_FALSE(is_used_as_it_is(camera, SE3(SO3(), {-0.3, 0.0, 0.0}))) << "right and left are swapped";
}

TEST(SensorChoice, TheSensorIsTheOneAskedForOrTheBestOfTheSource) {
  SourceInfo source = pair_of(distorted(), left_from_right());
  for (const bool right : {false, true}) {
    for (const bool depth : {false, true}) {
      source.has_right = right, source.has_depth = depth;
      const CameraKind best = depth ? CameraKind::depth : right ? CameraKind::stereo : CameraKind::mono;
      EXPECT_EQ(choose_sensor(options_of("auto"), source).sensor, best);
      EXPECT_EQ(choose_sensor(options_of("mono"), source).sensor, CameraKind::mono);
      if (right) {
        EXPECT_EQ(choose_sensor(options_of("stereo"), source).sensor, CameraKind::stereo);
      } else {
        EXPECT_THROW(choose_sensor(options_of("stereo"), source), Error);
      }
      if (depth) {
        EXPECT_EQ(choose_sensor(options_of("rgbd"), source).baseline, options_of("rgbd").virtual_baseline_m);
      } else {
        EXPECT_THROW(choose_sensor(options_of("rgbd"), source), Error);
      }
    }
  }
}

TEST(SensorChoice, LargeImagesHaveTwiceTheFeaturesUnlessTheirNumberIsGiven) {
  SourceInfo source;
  source.cameras = {{"left", distorted(), {}, ""}};
  Camera& camera = *source.cameras.front().camera;
  OrbSlamOptions options;
  options.features = 0;
  camera.height = 480;
  for (const auto& [width, features] : {std::pair{0, 1000}, {640, 1000}, {832, 1000}, {833, 2000}}) {
    camera.width = width;
    EXPECT_EQ(options_for(options, source, nullptr).features, features) << width;
  }
  options.features = 700;
  EXPECT_EQ(options_for(options, source, nullptr).features, 700);
  Map map;
  auto layer = std::make_shared<FeatureLayer>();
  layer->extraction = {
      .features = 1234, .levels = 5, .scale_factor = 1.3, .fast_threshold = 22, .least_fast_threshold = 9};
  map.layers.put<FeatureLayer>(std::move(layer));
  const OrbSlamOptions of_map = options_for(options, source, &map);
  EXPECT_EQ(of_map.features, 1234);
  EXPECT_EQ(of_map.levels, 5);
  EXPECT_EQ(of_map.scale_factor, 1.3);
  EXPECT_EQ(of_map.fast_threshold, 22);
  EXPECT_EQ(of_map.least_fast_threshold, 9);
}

TEST(SensorChoice, AnUnusablePairLeavesTheLeftCameraOrIsRefused) {
  SourceInfo uncalibrated = pair_of(distorted(), left_from_right());
  uncalibrated.left_from_right.reset();
  const SourceInfo one_above_the_other = pair_of(distorted(), SE3(SO3(), {0.0, 0.3, 0.0}));
  for (const SourceInfo& source : {uncalibrated, one_above_the_other}) {
    EXPECT_EQ(choose_sensor(options_of("auto"), source).sensor, CameraKind::mono);
    EXPECT_THROW(choose_sensor(options_of("stereo"), source), Error);
  }
}

TEST(SensorChoice, ADepthCameraMeasuresEveryFeatureOfTheWallForAnyPool) {
  Camera camera = distorted();
  SourceInfo source;
  source.cameras = {{"rgb", camera, {}, ""}};
  source.has_depth = true;
  const OrbSlamOptions options = options_of("rgbd");
  const SensorChoice choice = choose_sensor(options, source);
  Frame frame;
  frame.image = image_of_wall(camera, SE3());
  frame.depth = DepthImage(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) std::fill_n(frame.depth.row(y), camera.width, static_cast<float>(wall_m));
  TaskPool four(4);
  const auto alone = FeatureMaker(options, choice, nullptr).make(frame);
  const auto together = FeatureMaker(options, choice, &four).make(frame);
  EXPECT_EQ(alone->data().depths, together->data().depths);
  ASSERT_GT(alone->size(), 300U);
  for (const float depth : alone->data().depths) EXPECT_NEAR(static_cast<double>(depth), wall_m, 1e-3);
}

/// Features there move with what is nearer; the depth around them is of both.
TEST(SensorChoice, FeaturesAtALowStepOfDepthHaveNone) {
  const Camera camera = distorted();
  SourceInfo source;
  source.cameras = {{"rgb", camera, {}, ""}};
  source.has_depth = true;
  OrbSlamOptions options = options_of("rgbd");
  const SensorChoice choice = choose_sensor(options, source);
  Frame frame;
  frame.image = image_of_wall(camera, SE3());
  frame.depth = DepthImage(camera.width, camera.height);
  const double sigma = inverse_depth_sigma({}, 1.0 / wall_m);
  const auto features = FeatureMaker(options, choice, nullptr).make(frame);
  ASSERT_GT(features->size(), 300U);
  const int edge = static_cast<int>(std::lround(features->data().features.keypoints[100].x));
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      frame.depth.at(x, y) = static_cast<float>(1.0 / (1.0 / wall_m - (x < edge ? 0.0 : 11.0 * sigma)));
  const auto cautious = FeatureMaker(options, choice, nullptr).make(frame);
  options.depth_edge_sigmas = 4.0;
  const auto bold = FeatureMaker(options, choice, nullptr).make(frame);
  int at_edge = 0;
  for (std::size_t i = 0; i < cautious->size(); ++i) {
    const double from_edge = std::abs(static_cast<double>(cautious->data().features.keypoints[i].x) - (edge - 0.5));
    EXPECT_TRUE(from_edge < 1.0 || from_edge > 4.0 ? (cautious->data().depths[i] > 0.0F) == (from_edge > 4.0) : true);
    EXPECT_GT(bold->data().depths[i], 0.0F);
    at_edge += from_edge < 1.0 ? 1 : 0;
  }
  EXPECT_GT(at_edge, 0);
}

TEST(SensorChoice, WhatTheLensDoesNotShowWithAMarginOf16PixelsIsMasked) {
  const Camera camera = distorted();
  const SE3 turned(SO3::exp({0.1, -0.05, 0.15}), {0.3, 0.003, -0.004});
  const SensorChoice choice = choose_sensor(options_of("stereo"), pair_of(camera, turned));
  ASSERT_TRUE(choice.rectification);
  Frame frame;
  frame.image = GrayImage(camera.width, camera.height);
  const GrayImage mask = FrameRectifier(choice.rectification, nullptr).rectified(frame).mask;
  const GrayImage shown = shown_by(choice.rectification->left, camera.width, camera.height, 16);
  int masked = 0;
  for (int y = 0; y < shown.height(); ++y) {
    for (int x = 0; x < shown.width(); ++x) {
      ASSERT_EQ(mask.at(x, y), shown.at(x, y)) << x << ' ' << y;
      masked += mask.at(x, y) == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(masked, 3000);
}

TEST(SensorChoice, MasksAreRectifiedToo) {
  const Camera camera = distorted();
  const SensorChoice choice = choose_sensor(options_of("stereo"), pair_of(camera, left_from_right()));
  Frame frame;
  frame.image = image_of_wall(camera, SE3());
  frame.mask = GrayImage(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) std::fill(frame.mask.row(y) + 240, frame.mask.row(y) + 480, 255);
  const FrameRectifier rectifier(choice.rectification, nullptr);
  const Frame rectified = rectifier.rectified(frame);
  EXPECT_EQ(rectified.mask.at(100, 180), 0);
  EXPECT_EQ(rectified.mask.at(380, 180), 255);
  frame.image = GrayImage(100, 100);
  EXPECT_THROW(rectifier.rectified(frame), Error);
}

}  // namespace
}  // namespace rastro
