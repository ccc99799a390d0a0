// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/scene_writer.h"

#include <gtest/gtest.h>

#include "rastro/viewer/scene_block_testing.h"

namespace rastro {
namespace {

ViewScene scene_with_everything() {
  ViewScene scene;
  scene.title = "kitchen \"north\"", scene.method = "rgbd", scene.revision = 12;
  scene.metric = true, scene.scale_sigma = 0.01, scene.scale_origin = "depth camera";
  scene.up = {0.0, 0.6, 0.8};
  scene.sessions.push_back({0, 3, "kitchen", 1.5, 2.5});
  scene.frames.stamps_s = {1.5, 2.5, 3.5};
  scene.frames.positions = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  scene.frames.orientations = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 0};
  scene.frames.states = {0, 2, 5};
  scene.events.push_back({1, 2.5, "loop_closed", "with 3"});
  scene.keyframes = {{7}, {1.5}, {1, 2, 3, 0, 0, 0, 1}, {0}, {2}};
  scene.camera = SceneCamera{640, 480, 585.0, 586.0, 320.0, 240.0};
  scene.layers.emplace_back(SceneEdges{"loops", {0, 0}});
  scene.layers.emplace_back(ScenePoints{"cloud", {1, 2, 3}, {9, 8, 7}, {0.5F}, {0}, {}});
  scene.layers.emplace_back(SceneMesh{"mesh", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {}, {0, 1, 2}});
  scene.layers.emplace_back(SceneCubes{"octree", {1, 1, 1}, {0.05F}, {}});
  scene.layers.emplace_back(SceneGrid{"grid", 3, 1, 0.05, {-1.0, -2.0}, {0, 254, 255}});
  scene.layers.emplace_back(SceneEllipsoids{"covariances", {1, 1, 1}, {1, 0, 0, 0, 1, 0, 0, 0, 1}});
  scene.images.push_back({0, 2, 1, {0xFF, 0xD8, 0xFF}});
  return scene;
}

TEST(SceneWriter, KeepsEveryNumber) {
  const std::string bytes = scene_bytes(scene_with_everything());
  const SceneBlock block(bytes);
  EXPECT_EQ(block.header["format"], "rastro-scene");
  EXPECT_EQ(block.header["version"], 1);
  EXPECT_EQ(block.header["title"], "kitchen \"north\"");
  EXPECT_EQ(block.header["scale"], (SceneBlock::Json{{"kind", "metric"}, {"sigma", 0.01}, {"origin", "depth camera"}}));
  EXPECT_EQ(block.header["up"], (std::vector<double>{0.0, 0.6, 0.8}));
  EXPECT_EQ(block.header["sessions"][0]["robot"], 3);
  const auto& frames = block.header["frames"];
  EXPECT_EQ(block.numbers<double>(frames["stamps"]), (std::vector<double>{1.5, 2.5, 3.5}));
  EXPECT_EQ(block.numbers<float>(frames["positions"])[8], 9.0F);
  EXPECT_EQ(block.numbers<std::uint8_t>(frames["states"]), (std::vector<std::uint8_t>{0, 2, 5}));
  EXPECT_FALSE(frames.contains("online")) << "an empty array is left out";
  EXPECT_EQ(block.header["events"][0]["detail"], "with 3");
  const auto& keyframes = block.header["keyframes"];
  EXPECT_EQ(block.numbers<std::int32_t>(keyframes["ids"]), std::vector<std::int32_t>{7});
  EXPECT_EQ(block.numbers<std::int32_t>(keyframes["submaps"]), std::vector<std::int32_t>{2});
  EXPECT_EQ(block.header["camera"]["fy"], 586.0);
}

TEST(SceneWriter, KeepsEveryLayer) {
  const std::string bytes = scene_bytes(scene_with_everything());
  const SceneBlock block(bytes);
  ASSERT_EQ(block.layer_names(), (std::vector<std::string>{"loops", "cloud", "mesh", "octree", "grid", "covariances"}));
  EXPECT_EQ(block.numbers<std::uint32_t>(block.layer("loops")->at("pairs")), (std::vector<std::uint32_t>{0, 0}));
  EXPECT_EQ(block.numbers<std::uint8_t>(block.layer("cloud")->at("colors")), (std::vector<std::uint8_t>{9, 8, 7}));
  EXPECT_EQ(block.numbers<float>(block.layer("cloud")->at("sigmas")), std::vector<float>{0.5F});
  EXPECT_EQ(block.numbers<std::uint32_t>(block.layer("mesh")->at("triangles")), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(block.numbers<float>(block.layer("octree")->at("sizes")), std::vector<float>{0.05F});
  EXPECT_EQ(block.numbers<std::uint8_t>(block.layer("grid")->at("cells")), (std::vector<std::uint8_t>{0, 254, 255}));
  EXPECT_EQ(block.layer("grid")->at("origin"), (std::vector<double>{-1.0, -2.0}));
  EXPECT_EQ(block.numbers<float>(block.layer("covariances")->at("axes")).size(), 9U);
  EXPECT_EQ(block.numbers<std::uint8_t>(block.header["images"][0]["jpeg"]),
            (std::vector<std::uint8_t>{0xFF, 0xD8, 0xFF}));
}

TEST(SceneWriter, GivesTheSameBytesAgain) {
  EXPECT_EQ(scene_bytes(scene_with_everything()), scene_bytes(scene_with_everything()));
}

TEST(SceneWriter, TakesTextThatIsNoUtf8) {
  ViewScene scene;
  scene.title = "map \xff";
  EXPECT_EQ(SceneBlock(scene_bytes(scene)).header["title"], "map \xEF\xBF\xBD");
}

}  // namespace
}  // namespace rastro
