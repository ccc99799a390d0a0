// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/lsd_sensor.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/slam/lsd/lsd_frame.h"

namespace rastro {
namespace {

SourceInfo recording_of(bool right, bool depth) {
  Camera camera;
  camera.width = 64, camera.height = 48;
  camera.fx = camera.fy = 60.0, camera.cx = 31.5, camera.cy = 23.5;
  SourceInfo info;
  info.path = "recording";
  info.has_right = right;
  info.has_depth = depth;
  info.cameras.push_back({"left", camera, std::nullopt, "test"});
  if (!right) return info;
  info.cameras.push_back({"right", camera, std::nullopt, "test"});
  info.left_from_right = SE3(SO3(), {0.2, 0.0, 0.0});
  return info;
}

CameraKind chosen(const std::string& name, const SourceInfo& info) {
  LsdOptions options;
  options.sensor = name;
  return choose_lsd_sensor(options, info).kind;
}

TEST(LsdSensor, AutoTakesAllThatTheRecordingHas) {
  EXPECT_EQ(chosen("auto", recording_of(false, false)), CameraKind::mono);
  EXPECT_EQ(chosen("auto", recording_of(true, false)), CameraKind::stereo);
  EXPECT_EQ(chosen("auto", recording_of(true, true)), CameraKind::depth);
  EXPECT_EQ(chosen("stereo", recording_of(true, true)), CameraKind::stereo);
  EXPECT_EQ(chosen("mono", recording_of(true, true)), CameraKind::mono);
  EXPECT_THROW(chosen("rgbd", recording_of(true, false)), Error);
  EXPECT_THROW(chosen("stereo", recording_of(false, true)), Error);
}

TEST(LsdSensor, AutoDoesWithoutDepthWhereTheShutterRolls) {
  SourceInfo info = recording_of(false, true);
  info.cameras.front().camera->readout_s = 0.026;
  EXPECT_EQ(chosen("auto", info), CameraKind::mono);
  EXPECT_EQ(chosen("rgbd", info), CameraKind::depth);
}

TEST(LsdSensor, ThePairKnowsItsBaselineAndItsScale) {
  const LsdSensor pair = choose_lsd_sensor({}, recording_of(true, false));
  EXPECT_EQ(pair.baseline, 0.2);
  EXPECT_TRUE(pair.is_metric());
  EXPECT_TRUE(pair.scale().metric);
  EXPECT_EQ(pair.scale().origin, "stereo baseline");
  EXPECT_FALSE(choose_lsd_sensor({}, recording_of(false, false)).scale().metric);
}

TEST(LsdSensor, APairWithoutCalibrationIsOneCameraUnlessAskedFor) {
  SourceInfo info = recording_of(true, false);
  info.left_from_right.reset();
  EXPECT_EQ(chosen("auto", info), CameraKind::mono);
  EXPECT_THROW(chosen("stereo", info), Error);
}

/// An alignment takes black for clipped; depths are made from the image as it is.
TEST(LsdFrameMaker, MaskedPixelsAreBlackForTheAlignmentOnly) {
  const LsdSensor sensor = choose_lsd_sensor({}, recording_of(false, false));
  Frame recorded;
  recorded.image = GrayImage(64, 48);
  recorded.mask = GrayImage(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      recorded.image.at(x, y) = 100;
      recorded.mask.at(x, y) = x < 32 ? 255 : 0;
    }
  const LsdFrame frame = LsdFrameMaker(sensor, 2, nullptr).make(recorded);
  EXPECT_EQ(frame.image.at(50, 20), 100);
  EXPECT_EQ(frame.pyramid.level(0).row(20)[50], 0);
  EXPECT_EQ(frame.pyramid.level(0).row(20)[10], 100);
  EXPECT_EQ(frame.pyramid.level(1).row(10)[25], 0);
}

}  // namespace
}  // namespace rastro
