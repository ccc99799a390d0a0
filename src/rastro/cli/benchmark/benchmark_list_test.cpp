// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_list.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/cli/benchmark/benchmark_plan.h"

namespace rastro::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

BenchmarkList list_of(const std::string& entries) { return parse_benchmark_list("entries:\n" + entries, "list.yaml"); }

std::vector<std::string> names_in(const BenchmarkList& list) {
  std::vector<std::string> names;
  for (const BenchmarkEntry& entry : list.entries) names.push_back(entry.name);
  return names;
}

std::string error_in(const std::string& yaml) {
  try {
    parse_benchmark_list(yaml, "list.yaml");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string error_in_entry(const std::string& fields) { return error_in("entries:\n  - {" + fields + "}\n"); }

TEST(BenchmarkList, EntryHasDefaults) {
  const BenchmarkList list = list_of("  - {data: kitti_00, method: orb}\n");
  ASSERT_EQ(list.entries.size(), 1U);
  const BenchmarkEntry& entry = list.entries.front();
  EXPECT_EQ(entry.name, "kitti_00 orb");
  EXPECT_EQ(entry.method.command, "slam");
  EXPECT_THAT(entry.seeds, IsEmpty());
  EXPECT_EQ(entry.false_pose_limit_m, 0.1);
  EXPECT_TRUE(list.keep);
}

TEST(BenchmarkList, ListsOfValuesAreMultiplied) {
  const auto list = list_of("  - {world: [bedroom, study], method: [orb, rgbd], disturb: [none, mirror-depth]}\n");
  EXPECT_THAT(names_in(list),
              ElementsAre("bedroom orb", "bedroom orb mirror-depth", "bedroom rgbd", "bedroom rgbd mirror-depth",
                          "study orb", "study orb mirror-depth", "study rgbd", "study rgbd mirror-depth"));
  EXPECT_THAT(list.entries[1].disturbances, ElementsAre("mirror-depth"));
  EXPECT_THAT(list.entries[0].seeds, ElementsAre(1));
}

TEST(BenchmarkList, NamedEntryKeepsItsNameBeforeWhatVaries) {
  const auto list = list_of("  - {name: walk, world: loop, sensor: mono, method: [orb, rgbd], disturb: noise=5}\n");
  EXPECT_THAT(names_in(list), ElementsAre("walk orb noise=5", "walk rgbd noise=5"));
}

TEST(BenchmarkList, EverythingOfAnEntryIsRead) {
  const auto list = list_of(
      "  - {world: loop, seeds: [\"3:5\", 9], simulate: --stereo --frames 40, frames: \"2:30\", command: odometry,\n"
      "     method: features, settings: {features: 600}, flags: [--every, 2], disturb: black=3:5 + noise=2,\n"
      "     alignment: sim3, ground_truth: gt.txt, false_pose_limit_m: 2}\n");
  const BenchmarkEntry& entry = list.entries.front();
  EXPECT_THAT(entry.seeds, ElementsAre(3, 4, 9));
  EXPECT_THAT(entry.input.simulate, ElementsAre("--stereo", "--frames", "40"));
  EXPECT_EQ(entry.input.frames, "2:30");
  EXPECT_EQ(entry.method.command, "odometry");
  EXPECT_THAT(entry.method.settings, ElementsAre("features=600"));
  EXPECT_THAT(entry.method.flags, ElementsAre("--every", "2"));
  EXPECT_THAT(entry.disturbances, ElementsAre("black=3:5", "noise=2"));
  EXPECT_EQ(entry.alignment, "sim3");
  EXPECT_EQ(entry.false_pose_limit_m, 2.0);
  EXPECT_EQ(entry.name, "loop@2:30 odometry features black=3:5+noise=2");
}

TEST(BenchmarkList, MapIsOfTheSameRecordingUnlessItSaysOtherwise) {
  const auto list = list_of(
      "  - {data: a, frames: \"9:12\", flags: --every 2, method: orb, map: {frames: \"0:5\"}, expect: lost}\n"
      "  - {data: a, flags: --every 2, method: orb, map: {data: b}, expect: lost}\n"
      "  - {data: a, method: orb, map: {data: c, same_world: yes, settings: {seed: 3}}, expect: found}\n");
  EXPECT_EQ(list.entries[0].name, "a@9:12 in a@0:5 orb");
  EXPECT_TRUE(list.entries[0].map->same_world);
  EXPECT_EQ(list.entries[0].expect, Expectation::lost);
  EXPECT_THAT(list.entries[0].map->flags, ElementsAre("--every", "2"));
  EXPECT_FALSE(list.entries[1].map->same_world);
  EXPECT_THAT(list.entries[1].map->flags, IsEmpty()) << "flags of one recording do not fit another one";
  EXPECT_TRUE(list.entries[2].map->same_world);
  EXPECT_EQ(list.entries[2].expect, Expectation::found);
}

TEST(BenchmarkList, SettingsOfTheListHoldForAll) {
  const auto list = parse_benchmark_list(
      "about: a list\nkeep: no\ntimeout_s: 7\nfalse_pose_limit_m: 3\ntolerance: {time_percent: 50}\n"
      "entries: [{data: a, method: orb}]\n",
      "list.yaml");
  EXPECT_FALSE(list.keep);
  EXPECT_EQ(list.timeout_s, 7.0);
  EXPECT_EQ(list.entries.front().false_pose_limit_m, 3.0);
  EXPECT_EQ(list.tolerance.time_percent, 50.0);
  EXPECT_EQ(list.tolerance.ate_percent, 5.0);
}

TEST(BenchmarkList, UnknownKeysAreNamedWithTheNearestOne) {
  EXPECT_THAT(error_in("entires: []\n"), HasSubstr("did you mean 'entries'"));
  EXPECT_THAT(error_in_entry("data: a, metod: orb"), HasSubstr("did you mean 'method'"));
  EXPECT_THAT(error_in_entry("data: a, metod: orb"), HasSubstr("list.yaml:2"));
  EXPECT_THAT(error_in_entry("data: a, method: orb, map: {frame: 3}"), HasSubstr("did you mean 'frames'"));
  EXPECT_THAT(error_in("tolerance: {ate: 3}\nentries: [{data: a, method: orb}]\n"), HasSubstr("did you mean 'ate_m'"));
}

TEST(BenchmarkList, WrongValuesAreRefused) {
  EXPECT_THAT(error_in("entries: [\n"), HasSubstr("is not YAML"));
  EXPECT_THAT(error_in("entries: []\n"), HasSubstr("not a list of entries"));
  EXPECT_THAT(error_in("- a\n"), HasSubstr("not a map"));
  EXPECT_THAT(error_in_entry("method: orb"), HasSubstr("'world' are missing"));
  EXPECT_THAT(error_in_entry("data: a, world: loop, method: orb"), HasSubstr("both given"));
  EXPECT_THAT(error_in_entry("data: a"), HasSubstr("'method' is missing"));
  EXPECT_THAT(error_in_entry("data: a, method: orb, seeds: [1]"), HasSubstr("is for worlds"));
  EXPECT_THAT(error_in_entry("world: loop, method: orb, seeds: [5:2]"), HasSubstr("give numbers"));
  EXPECT_THAT(error_in_entry("data: a, method: orb, command: track"), HasSubstr("give slam or odometry"));
  EXPECT_THAT(error_in_entry("data: a, method: orb, expect: found"), HasSubstr("runs with a map"));
  EXPECT_THAT(error_in_entry("data: a, method: orb, disturb: swap-stero"), HasSubstr("did you mean 'swap-stereo'"));
  EXPECT_THAT(error_in_entry("data: a, method: orb, settings: [1]"), HasSubstr("not a map"));
  EXPECT_THAT(error_in_entry("data: a, method: orb, false_pose_limit_m: far"), HasSubstr("not a number"));
  EXPECT_THAT(error_in_entry("data: a, method: orb}\n  - {data: a, method: orb"), HasSubstr("two entries are called"));
}

TEST(BenchmarkList, ListsThatAreSuppliedCanBeRead) {
  const char* source_dir = std::getenv("RASTRO_SOURCE_DIR");
  if (source_dir == nullptr) GTEST_SKIP() << "RASTRO_SOURCE_DIR is not set";
  int lists = 0;
  for (const auto& file : std::filesystem::directory_iterator(std::filesystem::path(source_dir) / "bench/lists")) {
    EXPECT_FALSE(read_benchmark_list(file.path().string()).entries.empty()) << file.path();
    ++lists;
  }
  EXPECT_GE(lists, 4);
}

TEST(BenchmarkPlan, WorldsAreSimulatedOncePerSeed) {
  const auto list = list_of(
      "  - {world: loop, seeds: [1, 2], simulate: --frames 5, method: [orb, rgbd]}\n"
      "  - {name: other, world: loop, seeds: [1], simulate: --frames 5, method: orb, frames: \"0:3\"}\n");
  const BenchmarkPlan plan = plan_benchmark(list, ".");
  ASSERT_EQ(plan.runs.size(), 5U);
  EXPECT_EQ(plan.parts.size(), 2U);
  EXPECT_EQ(plan.runs[0].recording, plan.runs[1].recording) << "runs of one recording follow each other";
  EXPECT_EQ(plan.runs[1].recording, plan.runs[2].recording);
  EXPECT_EQ(plan.runs[3].seed, 2U);
  EXPECT_THAT(plan.parts.at(plan.runs[0].recording).words,
              ElementsAre("simulate", "loop", "--seed", "1", "--frames", "5"));
  EXPECT_THAT(plan.runs[0].words, ElementsAre("slam", below_out + plan.runs[0].recording, "--method", "orb"));
}

TEST(BenchmarkPlan, LocalizationNeedsAMapAndItsRecording) {
  const auto list = list_of("  - {world: loop, frames: \"9:12\", sensor: mono, method: orb, map: {frames: \"0:5\"}}\n");
  const BenchmarkPlan plan = plan_benchmark(list, ".");
  const BenchmarkRun& run = plan.runs.front();
  ASSERT_FALSE(run.map.empty());
  const BenchmarkPart& map = plan.parts.at(run.map);
  EXPECT_EQ(map.needs, run.recording);
  EXPECT_THAT(map.words, ElementsAre("slam", below_out + run.recording, "--method", "orb", "--frames", "0:5", "--set",
                                     "sensor=mono"));
  EXPECT_THAT(run.words, ElementsAre("localize", below_out + run.recording, "--map", below_out + run.map, "--frames",
                                     "9:12", "--set", "sensor=mono"));
  EXPECT_TRUE(run.judgment.localized);
  EXPECT_THAT(plan.command_of(run), HasSubstr("slam @out/"));
}

TEST(BenchmarkPlan, MissingRecordingsAreNamed) {
  const auto list = list_of("  - {data: nowhere, method: orb}\n");
  try {
    plan_benchmark(list, "/tmp");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/tmp/nowhere"));
    EXPECT_THAT(error.what(), HasSubstr("--data"));
  }
}

TEST(BenchmarkPlan, FileNamesAreSafeAndDiffer) {
  EXPECT_EQ(as_file_name("loop-1.2_3"), "loop-1.2_3");
  EXPECT_THAT(as_file_name("a/b c"), testing::StartsWith("a_b_c-"));
  EXPECT_NE(as_file_name("a/b c"), as_file_name("a b/c"));
  EXPECT_EQ(resolved("@out/worlds/x", "/o"), "/o/worlds/x");
  EXPECT_EQ(resolved("kitti", "/o"), "kitti");
}

}  // namespace
}  // namespace rastro::cli
