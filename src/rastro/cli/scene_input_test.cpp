// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/scene_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/cloud_scene.h"
#include "rastro/cli/run_notes.h"
#include "rastro/cli/track_scene.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/viewer/scene_block_testing.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* stats_header = "frame,stamp_ns,state,reason,score,used,total_ms,resident_mb,track_ms\n";

/// A run without a map: two poses, the second first given elsewhere.
fs::path make_run(const std::string& name) {
  const fs::path folder = scratch_folder(name);
  std::ofstream(folder / "trajectory.txt") << "# poses; meters\n1.0 0 0 0 0 0 0 1\n2.0 1 0 0 0 0 0 1\n";
  std::ofstream(folder / "trajectory_online.txt") << "# first\n1.0 0 0 0 0 0 0 1\n2.0 1.5 0 0 0 0 0 1\n";
  std::ofstream(folder / "stats.csv") << stats_header << "7,1000000000,tracking,none,1,9,12.5,1,3\n"
                                      << "8,2000000000,lost,few_inliers,1,9,13.5,1,\n";
  std::ofstream(folder / "events.jsonl") << R"({"frame": 8, "event": "lost", "text": "few_inliers: 3 of 40"})"
                                         << "\n";
  std::ofstream(folder / "covariance_online.txt") << "# c\n2.0 0.04 0 0 0 0 0 0.04 0 0 0 0 0.01 0 0 0 1 0 0 1 0 1\n";
  return folder;
}

std::string refusal(const fs::path& folder) {
  try {
    notes_of_run(read_export_input(folder.string()));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(CloudScene, ShowsThePointsOfAFile) {
  const fs::path file = scratch_folder("cloud") / "wall.ply";
  std::ofstream(file)
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
         "0 0 0 255 0 0\n1 0 0 0 255 0\n0 0 2 0 0 255\n";
  const NamedScene scene = cloud_scene(file.string(), 100, {});
  EXPECT_EQ(scene.name, "wall");
  EXPECT_FALSE(scene.tile_block) << "three points need no tiles";
  const SceneBlock block(scene.bytes);
  EXPECT_EQ(block.header["up"], (std::vector<double>{0.0, 0.0, 1.0}));
  EXPECT_EQ(block.header["planar"], false);
  EXPECT_EQ(block.numbers<std::uint8_t>(block.layer("cloud")->at("colors")),
            (std::vector<std::uint8_t>{255, 0, 0, 0, 255, 0, 0, 0, 255}));
}

TEST(TrackScene, ShowsFeaturesWithTheirTrailsEvenWithoutTheRecording) {
  const fs::path folder = scratch_folder("tracked");
  std::ofstream(folder / "about.json") << R"({"input": {"path": "/gone", "cameras": [{"size_px": [64, 48]}]}})";
  std::ofstream(folder / "tracks.csv") << "frame,stamp_ns,id,x_px,y_px,ray_x,ray_y,age,state,last_seen,frame_features,"
                                          "frame_lost,frame_masked,frame_health\n"
                                       << "10,1000000000,7,5,6,nan,nan,1,new,-1,1,0,0,good\n"
                                       << "12,1100000000,7,8,6,nan,nan,2,tracked,10,1,0,0,few corners\n";
  ASSERT_TRUE(is_track_run(folder.string()));
  const NamedScene scene = track_scene(folder.string());
  const SceneBlock block(scene.bytes);
  const auto& frames = block.header["frames"];
  EXPECT_EQ(block.numbers<double>(frames["stamps"]), (std::vector<double>{1.0, 1.1}));
  EXPECT_EQ(block.header["state_names"][block.numbers<std::uint8_t>(frames["states"])[1]], "weak");
  EXPECT_EQ(block.header["events"][0]["kind"], "few corners");
  const std::string bytes = scene.frame_block(1);
  const SceneBlock frame(bytes);
  EXPECT_EQ(frame.header["width"], 64);
  EXPECT_EQ(frame.numbers<std::int32_t>(frame.header["feature_ids"]), (std::vector<std::int32_t>{7}));
  EXPECT_EQ(frame.numbers<float>(frame.header["trails"]), (std::vector<float>{5, 6, 8, 6}));
  EXPECT_THROW(scene.frame_block(2), Error);
  EXPECT_FALSE(is_track_run(scratch_folder("none").string()));
}

TEST(SceneInput, ReadsWhatARunNoted) {
  const fs::path folder = make_run("noted");
  TaskPool pool(1);
  const NamedScene scene = scene_of(read_export_input(folder.string()), {}, pool, {});
  EXPECT_EQ(scene.name, "noted");
  const SceneBlock block(scene.bytes);
  EXPECT_EQ(block.header["title"], "noted");
  EXPECT_EQ(block.header["planar"], true) << "both poses are level";
  const auto& frames = block.header["frames"];
  EXPECT_EQ(block.numbers<float>(frames["positions"])[3], 1.0F);
  EXPECT_EQ(block.numbers<float>(frames["online"])[3], 1.5F);
  EXPECT_EQ(block.numbers<float>(frames["milliseconds"]), (std::vector<float>{12.5F, 13.5F}));
  EXPECT_FLOAT_EQ(block.numbers<float>(frames["sigmas"])[1], 0.3F);
  EXPECT_EQ(block.header["state_names"][block.numbers<std::uint8_t>(frames["states"])[1]], "lost");
  EXPECT_EQ(block.header["events"][0]["frame"], 1);
  EXPECT_EQ(block.header["events"][0]["detail"], "few_inliers: 3 of 40");
}

TEST(SceneInput, DoesWithoutWhatIsMissing) {
  const fs::path folder = make_run("bare");
  for (const char* file : {"trajectory_online.txt", "stats.csv", "events.jsonl", "covariance_online.txt"})
    fs::remove(folder / file);
  const RunRecord record = notes_of_run(read_export_input(folder.string()));
  EXPECT_EQ(record.trajectory.size(), 2U);
  EXPECT_TRUE(record.frames.empty() && record.online.empty() && record.events.empty() && record.uncertainties.empty());
}

TEST(SceneInput, GuessesUpOfPosesAlone) {
  const fs::path folder = make_run("camera");
  // A camera that pitches and rolls about its first view.
  std::ofstream(folder / "trajectory.txt")
      << "1.0 0 0 0 0.1 0 0 0.995\n2.0 0 0 1 -0.1 0 0 0.995\n3.0 0 0 2 0 0 0.1 0.995\n"
      << "4.0 0 0 3 0 0 -0.1 0.995\n";
  TaskPool pool(1);
  const NamedScene scene = scene_of(read_export_input(folder.string()), {}, pool, {});
  const SceneBlock block(scene.bytes);
  EXPECT_EQ(block.header["planar"], false);
  EXPECT_NEAR(block.header["up"][1].get<double>(), -1.0, 1e-6);
}

TEST(SceneInput, NamesTheDamagedLine) {
  const fs::path folder = make_run("damaged");
  std::ofstream(folder / "events.jsonl") << "{\"frame\": 1, \"event\": \"a\"}\n{\"frame\": 1}\n";
  EXPECT_THAT(refusal(folder), ::testing::HasSubstr("events.jsonl:2"));
  std::ofstream(folder / "stats.csv") << stats_header << "7,1000000000,tracking\n";
  EXPECT_THAT(refusal(folder), ::testing::HasSubstr("stats.csv:2"));
  std::ofstream(folder / "stats.csv") << "frame,features\n1,2\n";
  EXPECT_THAT(refusal(folder), ::testing::HasSubstr("no column 'stamp_ns'"));
}

TEST(SceneInput, NamesInputs) {
  const fs::path folder = make_run("a_run");
  EXPECT_EQ(scene_name(folder.string()), "a_run");
  EXPECT_EQ(scene_name(folder.string() + "/"), "a_run");
  EXPECT_EQ(scene_name((folder / "trajectory.txt").string()), "a_run");
  EXPECT_EQ(scene_name("/maps/office.rastro"), "office");
}

TEST(SceneInput, TakesAMapAlone) {
  ExportInput input;
  input.path = "ring.rastro";
  input.map = std::make_shared<const Map>(make_landmark_test_map());
  TaskPool pool(1);
  const NamedScene scene = scene_of(input, {}, pool, {});
  EXPECT_EQ(scene.name, "ring");
  EXPECT_NE(SceneBlock(scene.bytes).layer("landmarks"), nullptr);
}

TEST(SceneInput, RefusesWhatHasNothingToShow) {
  ExportInput input;
  input.path = "empty.rastro";
  input.map = std::make_shared<const Map>();
  TaskPool pool(1);
  EXPECT_THROW(scene_of(input, {}, pool, {}), Error);
  for (const std::int64_t points : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{1} << 40})
    EXPECT_THROW(scene_options({points, false, false, {}}, 0, 10), Error) << points;
  EXPECT_EQ(scene_options({}, 0, 10).max_points, 10U);
}

}  // namespace
}  // namespace rastro::cli
