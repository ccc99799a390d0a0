// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_run.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <mutex>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/benchmark/benchmark_session.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* two_seeds = "entries:\n  - {name: walk, world: loop, seeds: [1, 2], method: orb}\n";

/// Takes every command and makes its folder.
class FakeProgram {
 public:
  ChildEnd run(const std::vector<std::string>& words) {
    const std::lock_guard lock(mutex_);
    commands.push_back(words.front());
    const auto out = std::find(words.begin(), words.end(), "--out");
    fs::create_directories(*(out + 1));
    ChildEnd end;
    end.exit_code = words.front() == fails_at ? fails_with : 0;
    end.last_line = end.exit_code == 0 ? "" : "rastro: no";
    end.wall_s = 2.0;
    end.timed_out = words.front() == "slam" && too_slow;
    if (stop_after > 0 && static_cast<int>(commands.size()) >= stop_after) stop = true;
    end.stopped = stop && static_cast<int>(commands.size()) > stop_after;
    return end;
  }

  BenchmarkTools tools() {
    BenchmarkTools all;
    all.run = [this](const std::vector<std::string>& words) { return run(words); };
    all.score = [this](const fs::path&, const BenchmarkJudgment&, const fs::path& map_folder) {
      if (broken_score) throw Error("is not a result", "result.json", "run it again");
      RunScores scores;
      scores.frames = map_folder.empty() ? 10 : 20;
      scores.figures = {{"length_mean_m", std::numeric_limits<double>::quiet_NaN()}, {"frame_ms", 3.0}};
      return scores;
    };
    all.stop = &stop;
    return all;
  }

  long count_of(const std::string& command) const { return std::count(commands.begin(), commands.end(), command); }

  std::vector<std::string> commands;
  std::string fails_at;
  int fails_with = 0, stop_after = 0;
  bool broken_score = false, too_slow = false;
  std::atomic<bool> stop = false;

 private:
  std::mutex mutex_;
};

BenchmarkPlan plan_of(const std::string& yaml) {
  return plan_benchmark(parse_benchmark_list(yaml, "list.yaml"), fs::temp_directory_path());
}

struct Called {
  ResumedBenchmark resumed;
  std::vector<BenchmarkResult> results;
};

Called call(const BenchmarkPlan& plan, const BenchmarkSetup& setup, FakeProgram& program) {
  Called called;
  called.resumed = resume_benchmark(plan, setup);
  called.results = run_missing(plan, called.resumed, setup, program.tools());
  return called;
}

BenchmarkSetup setup_in(const std::string& name) {
  BenchmarkSetup setup;
  setup.out = scratch_folder(name);
  setup.program = "first";
  return setup;
}

TEST(BenchmarkRun, EachRunHasAResultAndIsNotRunAgain) {
  const BenchmarkPlan plan = plan_of(two_seeds);
  const BenchmarkSetup setup = setup_in("again");
  FakeProgram program;
  const auto results = call(plan, setup, program).results;
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(program.count_of("simulate"), 2);
  EXPECT_EQ(program.count_of("slam"), 2);
  EXPECT_EQ(results.front().scores.frames, 10);
  EXPECT_EQ(results.front().wall_s, 2.0);
  FakeProgram second;
  const Called called = call(plan, setup, second);
  EXPECT_EQ(called.results.size(), 2U);
  EXPECT_THAT(second.commands, IsEmpty());
  EXPECT_EQ(called.resumed.text(), "2 of 2 runs have results");
}

TEST(BenchmarkRun, AFigureThatIsNoNumberIsLeftOut) {
  const BenchmarkPlan plan = plan_of(two_seeds);
  const BenchmarkSetup setup = setup_in("nan");
  FakeProgram program;
  call(plan, setup, program);
  const ResumedBenchmark resumed = resume_benchmark(plan, setup);
  ASSERT_EQ(resumed.results.size(), 2U);
  EXPECT_EQ(resumed.results.front().scores.figures, (std::map<std::string, double>{{"frame_ms", 3.0}}));
}

TEST(BenchmarkRun, WhatTookTooLongRunsAgainWithMoreTime) {
  const BenchmarkPlan plan = plan_of(two_seeds);
  BenchmarkSetup setup = setup_in("time");
  setup.timeout_s = 2.0;
  FakeProgram program;
  program.too_slow = true;
  call(plan, setup, program);
  EXPECT_TRUE(resume_benchmark(plan, setup).missing.empty());
  setup.timeout_s = 60.0;
  const ResumedBenchmark resumed = resume_benchmark(plan, setup);
  EXPECT_EQ(resumed.missing.size(), 2U);
  EXPECT_THAT(resumed.text(), HasSubstr("2 run again: they have more time now"));
}

TEST(BenchmarkRun, ForceRunsAllAgainButWorldsStay) {
  const BenchmarkPlan plan = plan_of(two_seeds);
  BenchmarkSetup setup = setup_in("force");
  FakeProgram program;
  call(plan, setup, program);
  setup.force = true;
  call(plan, setup, program);
  EXPECT_EQ(program.count_of("slam"), 4);
  EXPECT_EQ(program.count_of("simulate"), 2) << "the recordings are of another command that did not change";
}

TEST(BenchmarkRun, InterruptedItGoesOnWhereItWas) {
  const BenchmarkPlan plan = plan_of(two_seeds);
  const BenchmarkSetup setup = setup_in("interrupted");
  FakeProgram program;
  program.stop_after = 3;  // simulate, slam, simulate
  EXPECT_EQ(call(plan, setup, program).results.size(), 1U);
  FakeProgram second;
  const Called called = call(plan, setup, second);
  EXPECT_EQ(called.results.size(), 2U);
  EXPECT_EQ(called.resumed.text(), "1 of 2 runs have results");
  EXPECT_EQ(second.count_of("slam"), 1);
  EXPECT_EQ(second.count_of("simulate"), 0) << "the world was complete";
}

TEST(BenchmarkRun, AnotherProgramOrListRunsAgainAndSaysSo) {
  BenchmarkSetup setup = setup_in("changed");
  FakeProgram program;
  call(plan_of(two_seeds), setup, program);
  setup.program = "second";
  const BenchmarkPlan plan = plan_of(two_seeds);
  EXPECT_EQ(resume_benchmark(plan, setup).text(), "0 of 2 runs have results; 2 run again: the program changed");
  setup.program = "first";
  const BenchmarkPlan changed =
      plan_of("entries:\n  - {name: walk, world: loop, seeds: [1, 2], method: orb, settings: {features: 900}}\n");
  EXPECT_EQ(resume_benchmark(changed, setup).text(), "0 of 2 runs have results; 2 run again: the list changed");
  const BenchmarkPlan limit =
      plan_of("false_pose_limit_m: 9\nentries:\n  - {name: walk, world: loop, seeds: [1, 2], method: orb}\n");
  EXPECT_EQ(resume_benchmark(limit, setup).other_command, 2) << "it is judged otherwise";
}

TEST(BenchmarkRun, ChangedFilesRunAgainAndSaySo) {
  const auto recording = scratch_folder("recording"), camera = scratch_path("camera.yaml");
  write_whole_file(recording / "info.txt", "1");
  write_whole_file(camera, "fx: 1\n");
  const std::string list = "entries:\n  - {data: " + recording.string() + ", method: orb, flags: --calibration " +
                           camera.string() + ", map: {frames: \"0:4\"}}\n";
  const BenchmarkSetup setup = setup_in("changed_files");
  FakeProgram program;
  call(plan_of(list), setup, program);
  fs::create_directories(recording / "run");
  write_whole_file(recording / "run/about.json", "{}");
  EXPECT_EQ(resume_benchmark(plan_of(list), setup).text(), "1 of 1 runs have results") << "a run kept with it";
  write_whole_file(camera, "fx: 20\n");
  const BenchmarkPlan calibrated = plan_of(list);
  EXPECT_EQ(resume_benchmark(calibrated, setup).text(),
            "0 of 1 runs have results; 1 run again: files that they read changed");
  call(calibrated, setup, program);
  EXPECT_EQ(program.count_of("slam"), 2) << "its map too";
  write_whole_file(recording / "info.txt", "22");
  EXPECT_EQ(resume_benchmark(plan_of(list), setup).other_files, 1);
}

TEST(BenchmarkRun, OtherThreadsOrJobsRunAgainAndSaySo) {
  const BenchmarkPlan plan = plan_of(two_seeds);
  BenchmarkSetup setup = setup_in("threads");
  FakeProgram program;
  call(plan, setup, program);
  fs::last_write_time(setup.out / plan.runs.front().recording, fs::file_time_type::clock::now());
  EXPECT_TRUE(resume_benchmark(plan_of(two_seeds), setup).missing.empty()) << "worlds are made by the benchmark itself";
  setup.threads = 2;
  EXPECT_EQ(resume_benchmark(plan, setup).text(),
            "0 of 2 runs have results; 2 run again: with other --jobs or --threads");
  setup.threads = 0, setup.jobs = 2;
  EXPECT_EQ(resume_benchmark(plan, setup).other_load, 2);
}

TEST(BenchmarkRun, WithoutKeepNothingButResultsIsLeft) {
  BenchmarkSetup setup = setup_in("keep_no");
  setup.keep = false;
  FakeProgram program;
  call(plan_of("entries:\n  - {world: loop, seeds: [1, 2], frames: \"5:9\", method: orb, map: {frames: \"0:4\"}}\n"),
       setup, program);
  EXPECT_TRUE(fs::is_empty(setup.out / "worlds"));
  EXPECT_TRUE(fs::is_empty(setup.out / "maps"));
  EXPECT_TRUE(fs::is_empty(setup.out / "runs"));
  EXPECT_FALSE(fs::is_empty(setup.out / "results"));
}

TEST(BenchmarkRun, OneMapServesAllWhoLocalizeInIt) {
  const BenchmarkPlan plan = plan_of(
      "entries:\n  - {world: loop, frames: \"5:9\", method: orb, disturb: [none, noise=3], map: {frames: \"0:4\"}}\n");
  FakeProgram program;
  BenchmarkSetup setup = setup_in("map");
  setup.jobs = 3;
  const auto results = call(plan, setup, program).results;
  EXPECT_EQ(program.count_of("simulate"), 1);
  EXPECT_EQ(program.count_of("slam"), 1);
  EXPECT_EQ(program.count_of("localize"), 2);
  EXPECT_EQ(results.back().scores.frames, 20) << "the map is given to who judges";
}

TEST(BenchmarkRun, FailuresAreResults) {
  FakeProgram program;
  program.fails_at = "slam", program.fails_with = 3;
  auto results = call(plan_of(two_seeds), setup_in("fails"), program).results;
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results.front().failure, "exit code 3: rastro: no");
  program.fails_at = "simulate";
  results = call(plan_of(two_seeds), setup_in("no_world"), program).results;
  EXPECT_THAT(results.front().failure, HasSubstr("'simulate loop --seed 1' failed"));
  program.fails_at = "", program.broken_score = true;
  results = call(plan_of(two_seeds), setup_in("no_score"), program).results;
  EXPECT_THAT(results.front().failure, HasSubstr("cannot be judged: "));
}

TEST(BenchmarkRun, AWorldThatCouldNotBeMadeIsTriedAgain) {
  FakeProgram program;
  const BenchmarkPlan plan = plan_of(two_seeds);
  const BenchmarkSetup setup = setup_in("no_world_yet");
  call(plan, setup, program);
  fs::remove_all(setup.out / "worlds");
  BenchmarkSetup forced = setup;
  forced.force = true;
  program.fails_at = "simulate", program.fails_with = 3;
  EXPECT_EQ(call(plan, forced, program).results.size(), 2U) << "both count as failed";
  program.fails_at = "";
  const Called called = call(plan, setup, program);
  EXPECT_EQ(called.resumed.missing.size(), 2U) << "neither that failure nor the result before it is left";
  EXPECT_EQ(called.results.front().failure, "");
}

TEST(BenchmarkRun, RefusalOfDisturbedInputIsAWarning) {
  FakeProgram program;
  program.fails_at = "slam", program.fails_with = 2;
  const auto plan = plan_of("entries:\n  - {world: loop, method: orb, disturb: [none, swap-stereo]}\n");
  auto results = call(plan, setup_in("refused"), program).results;
  EXPECT_EQ(results.front().failure, "exit code 2: rastro: no");
  EXPECT_EQ(results.back().failure, "");
  EXPECT_TRUE(results.back().scores.warned);
  EXPECT_EQ(results.back().message, "rastro: no");
}

TEST(BenchmarkRun, BrokenResultFilesAreRunAgain) {
  const BenchmarkPlan plan = plan_of(two_seeds);
  const BenchmarkSetup setup = setup_in("broken");
  FakeProgram program;
  call(plan, setup, program);
  write_whole_file(setup.out / "results" / (plan.runs.front().id + ".json"), "{\"entry\": 3}");
  EXPECT_EQ(resume_benchmark(plan, setup).missing.size(), 1U);
}

TEST(BenchmarkSession, OneCallAtATimeHasTheFolder) {
  const auto out = scratch_path("claimed");
  {
    const auto lock = claim_results(out);
    EXPECT_TRUE(fs::is_directory(out / "results"));
    EXPECT_THROW(claim_results(out), Error);
  }
  EXPECT_NO_THROW(claim_results(out));
}

TEST(ChildProcess, GivesExitCodeTimesMemoryAndLastLine) {
  const std::atomic<bool> stop = false;
  const ChildEnd end =
      run_child("/bin/sh", {"sh", "-c", "echo unseen; echo first >&2; echo 'rastro: last' >&2; exit 2"}, 60, stop);
  EXPECT_EQ(end.exit_code, 2);
  EXPECT_EQ(end.signal, 0);
  EXPECT_EQ(end.last_line, "rastro: last");
  EXPECT_GT(end.peak_memory_mb, 0.1);
  EXPECT_GT(end.wall_s, 0.0);
  EXPECT_EQ(failure_of(end), "exit code 2: rastro: last");
}

TEST(ChildProcess, HasItsOwnMemoryNotThatOfWhoStartsIt) {
  const std::atomic<bool> stop = false;
  const std::vector<char> mine(300'000'000, 'x');
  EXPECT_LT(run_child("/bin/sleep", {"sleep", "0.4"}, 60, stop).peak_memory_mb, 100.0);
  EXPECT_EQ(mine.back(), 'x');
}

TEST(ChildProcess, SignalsTimeoutsAndStopsAreTold) {
  std::atomic<bool> stop = false;
  EXPECT_EQ(run_child("/bin/sh", {"sh", "-c", "kill -9 $$"}, 60, stop).signal, 9);
  const ChildEnd late = run_child("/bin/sleep", {"sleep", "60"}, 0.0, stop);
  EXPECT_TRUE(late.timed_out);
  EXPECT_THAT(failure_of(late), HasSubstr("too long"));
  stop = true;
  EXPECT_TRUE(run_child("/bin/sleep", {"sleep", "60"}, 60, stop).stopped);
  EXPECT_EQ(run_child("/nowhere/program", {"program"}, 60, stop).exit_code, 127);
}

}  // namespace
}  // namespace rastro::cli
