// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/frame_block.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/viewer/request_rules.h"
#include "rastro/viewer/scene_block_testing.h"

namespace rastro {
namespace {

SourceInfo calibrated(int width, int height) {
  SourceInfo info;
  info.cameras.emplace_back().camera = Camera{width, height, 2.0, 2.0, 1.0, 1.0};
  return info;
}

TEST(FrameBlock, HasDepthAsPointsOfTheCameraInTheColorsOfTheImage) {
  Frame frame;
  frame.index = 7;
  frame.image = GrayImage(4, 2);
  frame.image.at(3, 1) = 200;
  frame.depth = DepthImage(4, 2);
  frame.depth.at(3, 1) = 4.0F;
  frame.depth.at(1, 1) = 2.0F;
  const std::string bytes = frame_block(frame, calibrated(4, 2));
  const SceneBlock block(bytes);
  EXPECT_EQ(block.header["index"], 7);
  EXPECT_EQ(block.header["width"], 4);
  EXPECT_EQ(block.numbers<float>(block.header.at("points")), (std::vector<float>{0, 0, 2, 4, 0, 4}));
  EXPECT_EQ(block.numbers<std::uint8_t>(block.header.at("colors")),
            (std::vector<std::uint8_t>{0, 0, 0, 200, 200, 200}));
}

TEST(FrameBlock, HasTheReturnsOfAScanInTheBodyFrame) {
  Frame frame;
  frame.scan.emplace();
  frame.scan->angle_step = 0.5 * std::numbers::pi;
  frame.scan->max_range = 10.0;
  frame.scan->ranges = {1.0F, 3.0F, 10.0F};
  frame.scan->body_from_laser = SE2(SO2(), {0.5, 0.0});
  const std::string bytes = frame_block(frame, {});
  const SceneBlock block(bytes);
  const auto points = block.numbers<float>(block.header.at("points"));
  ASSERT_EQ(points.size(), 6U) << "the third beam had no return";
  EXPECT_FLOAT_EQ(points[0], 1.5F);
  EXPECT_FLOAT_EQ(points[4], 3.0F);
  EXPECT_FALSE(block.header.contains("jpeg"));
}

TEST(FrameBlock, HasTheFeaturesThatWereFoundInTheImage) {
  Frame frame;
  frame.image = GrayImage(8, 6);
  LiveFeatures features;
  features.pixels = {1.5F, 2.0F};
  features.states = {1};
  features.ids = {42};
  features.state_names = {"matched", "new"};
  const std::string bytes = frame_block(frame, {}, &features);
  const SceneBlock block(bytes);
  EXPECT_EQ(block.numbers<float>(block.header["features"]), features.pixels);
  EXPECT_EQ(block.numbers<std::int32_t>(block.header["feature_ids"]), features.ids);
  EXPECT_EQ(block.header["feature_state_names"][1], "new");
  EXPECT_FALSE(SceneBlock(frame_block(frame, {})).header.contains("features"));
}

TEST(FrameBlock, IsServedByNumberAlone) {
  const auto block = [](std::int64_t frame) {
    if (frame > 9) throw Error("cannot be read", "frame", "");
    return "FRAME " + std::to_string(frame);
  };
  std::vector<NamedScene> scenes = {{"recording", "SCENE"}, {"run", "SCENE"}};
  scenes.front().frame_block = block;
  const detail::RequestRules rules(scenes, "s3cret", true, 8420);
  const auto reply_to = [&rules](const std::string& target) {
    return made(rules.reply_to({"GET", target, {"localhost:8420"}, "", ""}));
  };
  EXPECT_EQ(reply_to("/api/frame/0/7?token=s3cret").body, "FRAME 7");
  EXPECT_EQ(reply_to("/api/frame/0/7").status, 401);
  EXPECT_THAT(std::string(reply_to("/api/scenes?token=s3cret").body), ::testing::HasSubstr("\"frames\":true"));
  for (const char* target : {"/api/frame/0/10", "/api/frame/1/0", "/api/frame/2/0", "/api/frame/0", "/api/frame/0/",
                             "/api/frame/0/-1", "/api/frame/0/1/2", "/api/frame/0/99999999999999999999",
                             "/api/frame/0/../../etc/passwd", "/api/frame//etc/passwd"})
    EXPECT_EQ(reply_to(target + std::string("?token=s3cret")).status, 404) << target;
}

}  // namespace
}  // namespace rastro
