// SPDX-License-Identifier: Apache-2.0
// What a comparison is made of before anything runs: inputs, methods, plan, strengths, imports, lists.
#include <gmock/gmock.h>

#include <set>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/compare/compare_flags.h"
#include "rastro/cli/compare/compare_input.h"
#include "rastro/cli/compare/compare_list.h"
#include "rastro/cli/compare/compare_plan.h"
#include "rastro/cli/compare/imports.h"
#include "rastro/cli/compare/method_offers.h"
#include "rastro/cli/compare/strengths.h"

namespace rastro::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

template <typename Function>
std::string error_of(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::vector<std::string> names_of(const std::vector<MethodOffer>& offers) {
  std::vector<std::string> names;
  for (const MethodOffer& offer : offers) names.push_back(offer.name());
  return names;
}

TEST(CompareInput, FlagsOfAWorldAreForSimulate) {
  const CompareInput input = parse_compare_input("bedroom --frames 60", {"", {"--fov", "60"}, 3, ""});
  EXPECT_EQ(input.input.world, "bedroom");
  EXPECT_THAT(input.input.simulate, ElementsAre("--frames", "60"));
  EXPECT_THAT(input.seeds, ElementsAre(1, 2, 3));
  EXPECT_THAT(input.flags, IsEmpty()) << "a world knows its camera";
}

TEST(CompareInput, FlagsOfARecordingAreForEveryRun) {
  const auto folder = scratch_folder("my recording");
  const CompareInput input = parse_compare_input("my recording --frames 5:9 --intrinsics 1,2,3,4",
                                                 {"0:50", {"--rate", "10"}, 3, folder.parent_path().string()});
  EXPECT_EQ(input.name, "my recording");
  EXPECT_EQ(input.input.frames, "5:9") << "its own frames count";
  EXPECT_THAT(input.flags, ElementsAre("--rate", "10", "--intrinsics", "1,2,3,4"));
  EXPECT_THAT(input.seeds, IsEmpty());
}

TEST(CompareInput, AFolderNamedLikeAWorldDoesNotTakeItsPlace) {
  const auto folder = scratch_folder("bedroom");
  std::string warned;
  set_log_sink([&](LogLevel, const std::string& line) { warned += line; });
  const InputDefaults defaults{"", {}, 1, folder.parent_path().string()};
  EXPECT_EQ(parse_compare_input("bedroom", defaults).input.world, "bedroom");
  EXPECT_THAT(warned, HasSubstr("bedroom: is taken as the world"));
  EXPECT_FALSE(parse_compare_input(folder.string(), defaults).is_world());
  set_log_sink({});
}

TEST(CompareInput, FramesCountWhateverTheyAreOfAndHoweverTheyAreGiven) {
  const auto folder = scratch_folder("recording");
  const InputDefaults defaults{"0:50", {}, 1, ""};
  const CompareInput input = parse_compare_input(folder.string() + " --frames=5:9 --fov 60", defaults);
  EXPECT_EQ(input.frames(), "5:9");
  EXPECT_THAT(input.flags, ElementsAre("--fov", "60"));
  EXPECT_EQ(parse_compare_input("bedroom", defaults).frames(), "0:50") << "its runs get them too";
}

TEST(CompareInput, ARangeOfAWorldIsSimulatedToItsEndAndReadFromItsStart) {
  const InputDefaults defaults{"0:50", {}, 1, ""};
  const CompareInput input = parse_compare_input("loop --frames 20:80 --stereo", defaults);
  EXPECT_THAT(input.input.simulate, ElementsAre("--stereo", "--frames", "80"));
  EXPECT_EQ(input.frames(), "20:80") << "its own frames count";
  EXPECT_THAT(parse_compare_input("bedroom --frames=5:", {}).input.simulate, IsEmpty()) << "all that there are";
  EXPECT_THAT(parse_compare_input("bedroom --frames 60", defaults).input.simulate, ElementsAre("--frames", "60"));
  EXPECT_THAT(error_of([] { parse_compare_input("bedroom --frames 80:20", {}); }), HasSubstr("empty range"));
}

TEST(CompareInput, NamesAreUniqueAndUnknownOnesAreRefused) {
  const auto inputs = parse_compare_inputs({"hall", "hall --frames 5"}, {});
  EXPECT_EQ(inputs[1].name, "hall (2)");
  EXPECT_THAT(error_of([] { parse_compare_input("bedrom", {}); }), HasSubstr("did you mean 'bedroom'"));
  EXPECT_THAT(error_of([] { parse_compare_input("bedroom --seed 7", {}); }), HasSubstr("--seeds"));
}

TEST(CompareFlags, AListSaysWhichRunsThereAreAndHowLongTheyMayTake) {
  const auto file = scratch_path("list.yaml");
  write_whole_file(file, "timeout_s: 7\nkeep: no\nentries:\n  - {world: hall, method: orb}\n");
  CompareFlags flags;
  flags.inputs = {file.string()};
  std::string warned;
  set_log_sink([&](LogLevel, const std::string& line) { warned += line; });
  const CompareTask task = task_of(flags, "");
  set_log_sink({});
  EXPECT_THAT(warned, HasSubstr("keep: no"));
  EXPECT_EQ(session_of(flags, task).timeout_s, 7.0);
  flags.timeout_s = 9.0;
  EXPECT_EQ(session_of(flags, task).timeout_s, 9.0);
  EXPECT_EQ(session_of(CompareFlags(), CompareTask()).timeout_s, SessionFlags().timeout_s);
  flags.every = "2";
  EXPECT_THAT(error_of([&] { task_of(flags, ""); }), HasSubstr("--every: is not for a list"));
  flags.frames = "0:5";
  EXPECT_THAT(error_of([&] { task_of(flags, ""); }), HasSubstr("--frames: is not for a list"));
  flags.methods = {"orb"};
  EXPECT_THAT(error_of([&] { task_of(flags, ""); }), HasSubstr("--methods: is not for a list"));
}

TEST(MethodOffers, ANameStandsForEverySensor) {
  EXPECT_THAT(names_of(methods_named({"orb"})), ElementsAre("orb mono", "orb stereo", "orb rgbd"));
  EXPECT_THAT(names_of(methods_named({"orb:mono", "features"})), ElementsAre("orb mono", "features"));
  EXPECT_THAT(names_of(methods_named({"hector"})), ElementsAre("hector", "hector scan"));
  EXPECT_THAT(names_of(methods_named({"rgbd", "odometry/rgbd"})), ElementsAre("rgbd", "rgbd odometry"));
  EXPECT_EQ(methods_named({"orb:rgbd"}).front().kind, "depth");
  EXPECT_EQ(methods_named({"hector"}).front().kind, "laser");
  EXPECT_EQ(methods_named({"auto"}).front().kind, "auto") << "one column of its own, no rival in its tables";
  EXPECT_GT(methods_named({"all"}).size(), 10U);
  EXPECT_THAT(error_of([] { methods_named({"orbs"}); }), HasSubstr("did you mean 'orb'"));
}

TEST(ComparePlan, RepeatsHaveSeedsAndTheFirstRunsAgain) {
  CompareInput input;
  input.name = "room", input.input.world = "bedroom", input.seeds = {1, 2};
  ComparePlan plan;
  plan_methods(input, 0, methods_named({"orb:mono", "profiles"}), 2, plan);
  std::set<std::string> names;
  for (const BenchmarkEntry& entry : plan.list.entries) names.insert(entry.name);
  EXPECT_THAT(names, ElementsAre("room orb mono", "room orb mono again", "room orb mono repeat 2", "room profiles",
                                 "room profiles again"))
      << "no random numbers decide what profiles gives";
  EXPECT_THAT(plan.list.entries[1].method.flags, ElementsAre("--seed", "2"));
  EXPECT_THAT(plan.list.entries[2].method.flags, IsEmpty());
  EXPECT_EQ(plan_benchmark(plan.list, ".").runs.size(), 10U);
}

TEST(ComparePlan, ScansAreCutFromTheDepthOfTheSameInput) {
  CompareInput input;
  input.name = "room", input.input.world = "bedroom", input.input.frames = "0:9", input.seeds = {1};
  input.facts.has_ground_truth = true;
  ComparePlan plan;
  plan_methods(input, 0, methods_named({"hector:scan"}), 1, plan);
  const BenchmarkPlan benchmark = plan_benchmark(plan.list, ".");
  const BenchmarkPart& scans = benchmark.parts.at(benchmark.runs.front().recording);
  EXPECT_EQ(scans.words.front(), "convert");
  EXPECT_EQ(benchmark.parts.at(scans.needs).words.front(), "simulate");
  EXPECT_EQ(benchmark.runs.front().judgment.ground_truth, below_out + scans.needs) << "poses of the camera";
}

TEST(Strengths, GrowOnTheirOwnLadders) {
  EXPECT_EQ(ladders_named({"default"}).size(), strength_ladders().size());
  const StrengthLadder covered = ladders_named({"covered"}).front();
  EXPECT_EQ(assignment_of(covered, 15, 100), "black=100:115");
  EXPECT_EQ(assignment_of(ladders_named({"focal"}).front(), 0.95, 100), "focal-length=0.95");
  EXPECT_THAT(error_of([] { ladders_named({"nois"}); }), HasSubstr("did you mean 'noise'"));
}

TEST(Imports, NameInputFilesAndAlignment) {
  const auto file = scratch_path("theirs.txt"), cloud = scratch_path("theirs.ply");
  write_whole_file(file, "1 0 0 0 0 0 0 1\n");
  write_whole_file(cloud, "ply\n");
  const Import import = parse_import("their slam@room=" + file.string() + "," + cloud.string() + ",sim3");
  EXPECT_EQ(import.name, "their slam");
  EXPECT_EQ(import.input, "room");
  EXPECT_EQ(import.trajectory, file.string());
  EXPECT_EQ(import.cloud, cloud.string());
  EXPECT_EQ(import.alignment, "sim3");
  EXPECT_THAT(error_of([] { parse_import("theirs"); }), HasSubstr("NAME=trajectory.txt"));
  EXPECT_THAT(error_of([] { parse_import("theirs=no.txt"); }), HasSubstr("no such file"));
  EXPECT_FALSE(import.of_body);
  EXPECT_TRUE(parse_import("theirs=" + file.string() + ",body").of_body);
  EXPECT_THAT(error_of([&] { parse_import("theirs=" + file.string() + ",sim4"); }), HasSubstr("--import: 'sim4'"));
}

TEST(CompareList, EntriesThatReadTheSameAreOneInput) {
  const BenchmarkList list = parse_benchmark_list(
      "entries:\n"
      "  - {world: bedroom, simulate: --frames 9, method: [rgbd, orb], seeds: [1, 2]}\n"
      "  - {world: bedroom, simulate: --frames 9, method: orb, sensor: mono, seeds: [1, 2]}\n"
      "  - {name: tracks, world: bedroom, simulate: --frames 9, method: orb, settings: {frontend: tracks}, seeds: [1, "
      "2]}\n"
      "  - {world: bedroom, method: orb, disturb: noise=5}\n",
      "list.yaml");
  const ListedCells cells = cells_of(list);
  ASSERT_EQ(cells.inputs.size(), 2U);
  EXPECT_EQ(cells.inputs[1].name, "bedroom noise=5");
  EXPECT_EQ(cells.cells[2].input, 0U);
  EXPECT_EQ(cells.cells[2].column, "orb mono");
  EXPECT_EQ(cells.cells[3].column, "orb frontend=tracks");
  ComparePlan plan;
  plan_list(list, cells, cells.inputs, 3, plan);
  EXPECT_EQ(plan.list.entries.size(), 5U * 4U);
}

TEST(CompareList, WithoutASensorTheMethodTakesWhatTheInputHas) {
  const BenchmarkList list = parse_benchmark_list(
      "entries:\n"
      "  - {world: bedroom, method: [orb, fusion, rgbd]}\n"
      "  - {world: bedroom, method: orb, sensor: mono}\n"
      "  - {world: bedroom, method: lsd, settings: {sensor: mono}}\n"
      "  - {world: loop, method: [orb, rtabmap]}\n",
      "list.yaml");
  ListedCells cells = cells_of(list);
  ASSERT_EQ(cells.inputs.size(), 2U);
  cells.inputs[0].facts.has_depth = cells.inputs[1].facts.has_right = true;
  choose_sensors(list, cells.inputs, cells);
  std::vector<std::string> columns, kinds;
  for (const ListedCell& cell : cells.cells) columns.push_back(cell.column), kinds.push_back(cell.method.kind);
  EXPECT_THAT(columns, ElementsAre("orb rgbd", "fusion rgbd", "rgbd", "orb mono", "lsd mono sensor=mono", "orb stereo",
                                   "rtabmap stereo"));
  EXPECT_THAT(kinds, ElementsAre("depth", "depth", "depth", "mono", "mono", "stereo", "stereo"));
  ComparePlan plan;
  plan_list(list, cells, cells.inputs, 1, plan);
  EXPECT_EQ(plan.list.entries.front().method.sensor, "") << "it runs as the list says";
}

}  // namespace
}  // namespace rastro::cli
