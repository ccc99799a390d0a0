// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/session/frame_numbers.h"
#include "rastro/session/run_folder.h"
#include "rastro/session/run_result.h"
#include "rastro/session/time_histogram.h"

namespace rastro {
namespace {

TEST(TimeHistogram, AgreesWithSortingWithinItsBins) {
  Random random(7);
  TimeHistogram histogram;
  std::vector<double> all;
  for (int i = 0; i < 5000; ++i) {
    all.push_back(std::exp(random.uniform(-3.0, 5.0)));
    histogram.add(all.back());
  }
  std::sort(all.begin(), all.end());
  for (const double share : {0.05, 0.5, 0.95, 0.99}) {
    const double exact = all[static_cast<std::size_t>(share * 5000.0) - 1];
    EXPECT_NEAR(histogram.percentile_ms(share) / exact, 1.0, 0.006) << share;
  }
}

TEST(TimeHistogram, CountsValuesOutOfRange) {
  TimeHistogram histogram;
  EXPECT_EQ(histogram.percentile_ms(0.95), 0.0);
  histogram.add(0.0);
  histogram.add(1e9);
  EXPECT_EQ(histogram.count(), 2);
  EXPECT_GT(histogram.percentile_ms(1.0), 1e4);
}

TEST(FrameNumbers, MapsRunningNumbersToThoseOfTheRecording) {
  const std::vector<std::int64_t> recorded = {5, 7, 9, 10, 11, 12, 20, 30, 31, 33};
  FrameNumbers numbers;
  for (const std::int64_t number : recorded) numbers.add(number);
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    EXPECT_EQ(numbers.recorded(static_cast<std::int64_t>(i)), recorded[i]) << i;
  }
  EXPECT_EQ(numbers.recorded(-1), -1);
}

TEST(RunFolder, RefusesToMixRuns) {
  const auto path = scratch_path("folder");
  RunFolder(path, false).write_result("{}");
  EXPECT_THROW(RunFolder(path, false), Error);
  write_whole_file(path / "notes.txt", "mine");
  write_whole_file(path / "tracks.csv", "old");
  const RunFolder again(path, true);
  EXPECT_FALSE(std::filesystem::exists(path / "result.json"));
  EXPECT_FALSE(std::filesystem::exists(path / "tracks.csv"));
  EXPECT_EQ(read_whole_file(path / "notes.txt"), "mine") << "what is not ours stays";
}

TEST(RunFolder, DiscardLeavesOnlyOtherFiles) {
  const auto path = scratch_path("discard");
  std::filesystem::create_directories(path / "track_images");
  RunFolder(path, true).discard();
  EXPECT_FALSE(std::filesystem::exists(path));
  const RunFolder folder(path, false);
  folder.write_result("{}");
  write_whole_file(path / "notes.txt", "mine");
  folder.discard();
  EXPECT_FALSE(std::filesystem::exists(path / "result.json"));
  EXPECT_EQ(read_whole_file(path / "notes.txt"), "mine");
}

TEST(RunFolder, AFormerRunComesBackWhereTheNewOneHasNoFrame) {
  const auto path = scratch_path("former");
  const auto has_former = [&] {
    return read_whole_file(path / "result.json") == "former" &&
           read_whole_file(path / "track_images/1.png") == "picture" && !std::filesystem::exists(path / "former_run");
  };
  {
    RunFolder former(path, false);
    former.write_result("former");
    std::filesystem::create_directories(path / "track_images");
    write_whole_file(path / "track_images/1.png", "picture");
  }
  {
    const RunFolder discarded(path, true);
    EXPECT_FALSE(std::filesystem::exists(path / "result.json"));
    write_whole_file(path / "map.rastro", "new");
    discarded.discard();
    EXPECT_TRUE(has_former());
  }
  { const RunFolder unused(path, true); }  // as by an error before the first frame
  EXPECT_TRUE(has_former());
  EXPECT_FALSE(std::filesystem::exists(path / "map.rastro"));
  std::filesystem::create_directories(path / "former_run/track_images");
  std::filesystem::rename(path / "track_images/1.png", path / "former_run/track_images/1.png");
  std::filesystem::rename(path / "result.json", path / "former_run/result.json");
  write_whole_file(path / "about.json", "killed before its first frame");
  { const RunFolder unused(path, true); }
  EXPECT_TRUE(has_former());
  EXPECT_FALSE(std::filesystem::exists(path / "about.json"));
  { RunFolder(path, true).add_stats(OdometryUpdate{}); }  // killed by a frame
  EXPECT_FALSE(std::filesystem::exists(path / "result.json"));
  EXPECT_EQ(read_whole_file(path / "former_run/result.json"), "former");
  const RunFolder last(path, true);
  last.write_result("last");
  last.discard();
  EXPECT_FALSE(std::filesystem::exists(path / "result.json")) << "it had been replaced";
  EXPECT_FALSE(std::filesystem::exists(path / "former_run"));
}

TEST(RunFolder, RefusesAPathThatIsNoFolder) {
  const auto path = scratch_path("file");
  write_whole_file(path, "a file");
  EXPECT_THROW(RunFolder(path, true), Error);
  EXPECT_THROW(RunFolder("", true), Error);
  EXPECT_THROW(RunFolder("/proc/nowhere/run", false), Error);
}

TEST(RunFolder, AboutHasVersionMachineAndInput) {
  const auto path = scratch_path("about");
  const RunFolder folder(path, false);
  SourceInfo input;
  input.path = "caf\xe9";  // not UTF-8
  input.frame_count = 12;
  input.cameras.push_back({"cam0", Camera{}, {}, "sensor.yaml"});
  folder.write_about(input, "rastro track caf --out x");
  const auto json = nlohmann::json::parse(read_whole_file(path / "about.json"));
  EXPECT_EQ(json["command_line"], "rastro track caf --out x");
  EXPECT_EQ(json["input"]["frames"], 12);
  EXPECT_EQ(json["input"]["cameras"][0]["calibration_file"], "sensor.yaml");
  EXPECT_TRUE(json.contains("version") && json.contains("commit") && json.contains("machine"));
}

TEST(TrackResult, JsonHasTheNamesOthersRelyOn) {
  TrackResult result;
  result.frames = 30;
  result.coverage = 100.0;
  result.ms_per_frame_mean = 4.56789;
  result.result_sha256 = "ab";
  const auto json = nlohmann::json::parse(to_json(result));
  EXPECT_EQ(json["frames"], 30);
  EXPECT_EQ(json["ms_per_frame_mean"], 4.5679);
  for (const char* name : {"coverage", "ms_per_frame_p95", "peak_memory_mb", "result_sha256", "reidentified",
                           "mean_track_length", "interrupted", "options_sha256"}) {
    EXPECT_TRUE(json.contains(name)) << name;
  }
}

TEST(Limit, KeepsAndMisses) {
  TrackResult result;
  result.coverage = 95.0;
  EXPECT_TRUE(Limit("coverage>=95").kept_by(result));
  EXPECT_TRUE(Limit(" coverage <= 95 ").kept_by(result));
  EXPECT_FALSE(Limit("coverage>95").kept_by(result));
  EXPECT_FALSE(Limit("coverage<95").kept_by(result));
  EXPECT_EQ(Limit("coverage>95").complaint(result), "coverage>95 missed: it is 95");
}

TEST(Limit, NamesTheNearestNumber) {
  try {
    Limit("covrage>=95");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean 'coverage'"));
  }
  for (const char* text : {"coverage", "coverage>=", ">=5", "coverage=>95", "coverage>=x", "coverage==95", ""}) {
    EXPECT_THROW(Limit{text}, Error) << text;
  }
}

}  // namespace
}  // namespace rastro
