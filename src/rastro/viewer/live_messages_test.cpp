// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/live_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "rastro/base/random.h"
#include "rastro/viewer/feature_trails.h"
#include "rastro/viewer/scene.h"

namespace rastro {
namespace {

using nlohmann::json;

TEST(LiveMessages, TakeTheCommandsTheyNameAndNothingElse) {
  for (const LiveCommand command :
       {LiveCommand::pause, LiveCommand::resume, LiveCommand::step, LiveCommand::mapping_on, LiveCommand::mapping_off,
        LiveCommand::reset, LiveCommand::save, LiveCommand::end}) {
    const std::string message = json{{"command", name_of(command)}}.dump();
    EXPECT_EQ(live_command_in(message), command) << message;
  }
  for (const char* message : {"", "pause", "\"pause\"", "{}", "[]", "{\"command\":1}", "{\"command\":\"stop\"}",
                              "{\"command\":\"pause\",\"more\":1}", "{\"command\":\"pause\"", "{\"command\":null}"})
    EXPECT_EQ(live_command_in(message), std::nullopt) << message;
}

TEST(LiveMessages, DamagedCommandsAreNoCommandOrAnother) {
  Random random(5);
  const std::string whole = "{\"command\":\"pause\"}";
  int taken = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    std::string damaged = whole;
    for (int k = 0; k < 2; ++k)
      damaged[random.below(static_cast<std::uint32_t>(damaged.size()))] = static_cast<char>(random.below(256));
    taken += live_command_in(damaged) ? 1 : 0;
  }
  EXPECT_LT(taken, 50) << "of 5000, by bytes that stayed what they were";
}

TEST(LiveMessages, AFrameHasItsNumbersAndTheClientsEnd) {
  LiveFrame frame;
  frame.index = 17;
  frame.stamp_s = 1.5;
  frame.state = 2;
  frame.reason = "blurred";
  frame.detail = "a \"name\" that is no UTF-8: \xff";
  frame.world_from_body = SE3(SO3(), {1.0, 2.0, 3.0});
  frame.stages = {{"follow", 3.25}};
  frame.events = {{"loop_closed", "with 3"}};
  const json message = json::parse(message_of(frame) + ",\"dropped\":4}");
  EXPECT_EQ(message["type"], "frame");
  EXPECT_EQ(message["index"], 17);
  EXPECT_EQ(message["state"], 2);
  EXPECT_EQ(message["pose"], json({1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0}));
  EXPECT_TRUE(message["sigma"].is_null());
  EXPECT_EQ(message["stages"]["follow"], 3.25);
  EXPECT_EQ(message["events"][0]["kind"], "loop_closed");
  EXPECT_EQ(message["dropped"], 4);
  EXPECT_FALSE(message.contains("advice"));
}

TEST(LiveMessages, HelloNamesTheStatesAndTheCommands) {
  LiveHello hello{"run", "orb", std::nullopt, {LiveCommand::pause, LiveCommand::end}};
  const json message = json::parse(message_of(hello));
  EXPECT_EQ(message["state_names"], json(scene_state_names()));
  EXPECT_EQ(message["commands"], json({"pause", "end"}));
  EXPECT_TRUE(message["frames"].is_null());
  hello.frames = 240;
  EXPECT_EQ(json::parse(message_of(hello))["frames"], 240);
}

TEST(LiveMessages, ACalibrationSaysWhatWasShownAndWhatToDo) {
  LiveCalibration calibration;
  calibration.line = "hold it still";
  calibration.views = 7;
  calibration.enough_views = 20;
  calibration.wanted_tilt_deg = 15.0;
  calibration.missing = {"lower left"};
  calibration.cameras = {{"left", {0, 1, 1, 1}, {1}, {23.5, 0.0, 4.0, 8.0}}};
  calibration.outlines = {{1.0F, 2.0F, 3.5F, 4.0F}};
  const json message = json::parse(message_of(calibration));
  EXPECT_EQ(message["type"], "calibration");
  EXPECT_EQ(message["views"], 7);
  EXPECT_EQ(message["enough"], false);
  EXPECT_EQ(message["cameras"][0]["name"], "left");
  EXPECT_EQ(message["cameras"][0]["seen"], json({0, 1, 1, 1}));
  EXPECT_EQ(message["cameras"][0]["tilts"][0], 23.5);
  EXPECT_EQ(message["outlines"][0][2], 3.5);
  LiveHello hello{"camera", "calibrate", std::nullopt, {}};
  hello.state_names = {"no_board", "taken"};
  EXPECT_EQ(json::parse(message_of(hello))["state_names"], json({"no_board", "taken"}));
}

TEST(LiveMessages, AnImageIsABlockOfItsArrays) {
  LiveImage image{3, 640, 480, {1, 2, 3}, {}};
  image.features.pixels = {10.5F, 20.5F};
  image.features.states = {3};
  image.features.state_names = {"matched", "new"};
  const std::string block = block_of(image);
  std::uint32_t length = 0;
  std::memcpy(&length, block.data(), sizeof length);
  const json header = json::parse(block.substr(4, length));
  const std::string body = block.substr(4 + length);
  EXPECT_EQ((4 + length) % 8, 0U);
  EXPECT_EQ(header["width"], 640);
  EXPECT_EQ(body.substr(header["jpeg"]["offset"], 3), "\x01\x02\x03");
  float x = 0.0F;
  std::memcpy(&x, body.data() + header["features"]["offset"].get<std::size_t>(), sizeof x);
  EXPECT_EQ(x, 10.5F);
  EXPECT_EQ(header["feature_states"]["count"], 1);
  EXPECT_EQ(header["feature_state_names"], json({"matched", "new"}));
  EXPECT_FALSE(header.contains("trails"));
}

LiveFeatures features_at(std::vector<std::int32_t> ids, float x) {
  LiveFeatures features;
  features.ids = std::move(ids);
  for (std::size_t k = 0; k < features.ids.size(); ++k)
    features.pixels.insert(features.pixels.end(), {x, static_cast<float>(k)});
  return features;
}

TEST(FeatureTrails, LeadFromFrameToFrameAndOverGaps) {
  FeatureTrails trails;
  trails.add(features_at({7, 9, -1}, 1.0F));
  trails.add(features_at({9}, 2.0F));
  LiveFeatures now = features_at({7, 9, -1}, 3.0F);
  trails.add(now);
  trails.write_to(now);
  EXPECT_EQ(now.trail_lengths, (std::vector<std::uint8_t>{2, 3, 0}));
  EXPECT_EQ(now.trails, (std::vector<float>{1, 0, 3, 0, 1, 1, 2, 0, 3, 1}));
}

TEST(FeatureTrails, AreBoundedInLengthAndTime) {
  FeatureTrails trails;
  LiveFeatures now;
  for (int k = 0; k < 100; ++k) trails.add(now = features_at({1}, static_cast<float>(k)));
  trails.write_to(now);
  EXPECT_EQ(now.trail_lengths.front(), 24);
  EXPECT_EQ(now.trails[46], 99.0F);
  for (int k = 0; k < 50; ++k) trails.add(features_at({2}, 0.0F));
  trails.add(now = features_at({1}, 5.0F));
  trails.write_to(now);
  EXPECT_EQ(now.trails, (std::vector<float>{5, 0})) << "missing for too long";
}

}  // namespace
}  // namespace rastro
