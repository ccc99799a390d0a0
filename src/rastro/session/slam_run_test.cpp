// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/slam_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/memory.h"
#include "rastro/base/sanitizer_testing.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/images/room_map_testing.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/session/fakes_testing.h"
#include "rastro/session/slam_stats.h"
#include "rastro/session/trajectory_text.h"

namespace rastro {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Moves 0.5 m per frame along x, closes a loop every tenth frame, and is weak on every seventh.
class FakeSlam : public Slam {
 public:
  SlamUpdate process(const Frame& frame) override {
    if (frame.index == fault_at) throw std::runtime_error("out of order");
    SlamUpdate update;
    masked += frame.mask.empty() ? 0 : frame.mask.at(3, 2);
    update.index = frame.index;
    update.stamp = frame.stamp;
    update.state = frame.index % 7 == 6 ? SlamState::weak : SlamState::tracking;
    if (update.state == SlamState::weak) {
      update.reason = SlamReason::few_returns;
      update.detail = "3 of 180";
    }
    if (frame.index < apart_until) update.state = SlamState::weak, update.reason = SlamReason::apart;
    update.world_from_body = SE3({}, {0.5 * static_cast<double>(trajectory_.size()), 0.0, 0.0});
    update.covariance = Matrix6d(1e-4 * Matrix6d::Identity());
    update.times.push_back({"match", 1.0});
    if (frame.index % 10 == 9) {
      update.events.push_back({"loop_closed", "with 0"});
      update.times.push_back({"loop", 2.0});
    }
    trajectory_.push_back({frame.stamp, update.world_from_body});
    return update;
  }
  std::vector<SlamEvent> finish() override {
    ++finished;
    if (finish_fails) throw std::runtime_error("a job failed");
    return {{"loop_closed", "at last"}};
  }
  Trajectory trajectory() const override { return trajectory_; }
  void reset() override { trajectory_.clear(); }
  std::int64_t dropped_frames() const override { return dropped; }
  MapMemory map_memory() const override { return {2'500'000, budget, budget > 0 ? "spared" : ""}; }
  std::shared_ptr<const Map> snapshot() const override {
    if (given) return given;
    auto map = std::make_shared<Map>();
    map->method = "fake";
    map->sessions.push_back({0, 0, "", 0, 0, {true, 0.0, "wheels"}});
    map->keyframes.resize(2);
    map->keyframes[1].id = 1;
    map->keyframes[1].parent = 0;
    auto known = std::make_shared<LandmarkLayer>();
    known->landmarks.resize(3);
    known->estimates.resize(3);
    for (std::size_t k = 0; k < 3; ++k) known->landmarks[k].id = static_cast<std::int64_t>(k);
    map->layers.put<LandmarkLayer>(std::move(known));
    return map;
  }

  std::int64_t fault_at = -1;
  bool finish_fails = false;
  std::int64_t apart_until = 0;
  std::int64_t dropped = 0;
  std::size_t budget = 0;
  int finished = 0, masked = 0;
  std::shared_ptr<const Map> given;  ///< Its map; null: one of its own.

 private:
  Trajectory trajectory_;
};

SlamRun wired(Source& source, Slam& method) {
  SlamRun run;
  run.source = &source;
  run.method = &method;
  return run;
}

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  const std::string text = read_text_file(file.string());
  std::vector<std::string> lines;
  for (const std::string_view line : split(text, '\n'))
    if (!line.empty()) lines.emplace_back(line);
  return lines;
}

TEST(SlamRun, AMethodThatFailsAtItsEndStillGivesItsTrajectoryAndMap) {
  FakeSource source(30, {});
  FakeSlam method;
  method.finish_fails = true;
  const SlamRunEnd end = slam_run(wired(source, method));
  EXPECT_EQ(end.result.ended, "fault: a job failed");
  EXPECT_TRUE(end.failure);
  EXPECT_EQ(end.trajectory.size(), 30U);
  ASSERT_TRUE(end.map);
  EXPECT_EQ(end.result.keyframes, 2);
}

TEST(SlamRun, FramesApartFromTheMapAreNotRecalled) {
  FakeSource source(20, {});
  FakeSlam method;
  method.apart_until = 5;
  EXPECT_NEAR(slam_run(wired(source, method)).result.recall, 75.0, 1e-9);
}

TEST(SlamRun, CountsStatesLoopsAndCoverage) {
  FakeSource source(30, {4, 5});
  FakeSlam method;
  SlamRun run = wired(source, method);
  run.frames_asked = 30;
  const SlamRunEnd end = slam_run(run);
  EXPECT_EQ(end.result.frames, 28);
  EXPECT_EQ(end.result.skipped_frames, 2);
  EXPECT_EQ(end.result.states.weak, 4);
  EXPECT_EQ(end.result.states.tracking, 24);
  EXPECT_EQ(end.result.reasons.at("few_returns"), 4);
  EXPECT_EQ(end.result.loops_closed, 4) << "three during the run, one at the end";
  EXPECT_NEAR(end.result.recall, 100.0 * 28 / 30, 1e-9);
  EXPECT_DOUBLE_EQ(end.result.seconds_to_first_pose.value(), 0.0);
  EXPECT_EQ(end.result.landmarks, 3);
  EXPECT_EQ(end.result.keyframes, 2);
  EXPECT_DOUBLE_EQ(end.result.path_length, 13.5);
  EXPECT_NEAR(end.result.coverage, 100.0 * 28 / 30, 1e-9);
  EXPECT_NEAR(end.result.timing.recording_seconds, 29 * 0.05, 1e-9);
  EXPECT_EQ(end.position_covariances.size(), 7U) << "one every two meters";
  EXPECT_EQ(method.finished, 1);
  EXPECT_EQ(end.result.ended, "end of data");
  EXPECT_THAT(end.first_skip, HasSubstr("frame 4"));
}

/// Positions are half a meter apart, along x.
TEST(SlamRun, CovariancesHaveTheErrorOfTheCalibration) {
  for (const double share : {0.0, 0.01}) {
    FakeSource source(20, {});
    CalibratedCamera camera{"camera", Camera(), std::nullopt, "camera.yaml"};
    camera.calibration_error = share;
    source.describe(camera);
    FakeSlam method;
    SlamRun run = wired(source, method);
    run.initial_pose = SE3({}, {1.5, 0.0, 0.0});
    const SlamRunEnd end = slam_run(run);
    ASSERT_GT(end.position_covariances.size(), 3U);
    for (const PositionCovariance& at : end.position_covariances) {
      const double added = share * (at.position.x() - 1.5);
      EXPECT_NEAR(at.covariance(0, 0), 1e-4 + added * added, 1e-12);
    }
  }
}

TEST(SlamRun, WritesAsItGoes) {
  const auto path = scratch_path("slam_run");
  RunFolder folder(path, false);
  FakeSource source(20, {4});
  FakeSlam method;
  SlamRun run = wired(source, method);
  run.folder = &folder;
  slam_run(run);
  EXPECT_EQ(lines_of(path / "trajectory_online.txt").size(), 2U + 19U);
  EXPECT_EQ(lines_of(path / "covariance_online.txt").size(), 2U + 19U);
  EXPECT_EQ(split_words(lines_of(path / "covariance_online.txt").back()).size(), 22U);
  const auto events = lines_of(path / "events.jsonl");
  EXPECT_THAT(events, testing::Contains(HasSubstr("few_returns: 3 of 180")));
  EXPECT_THAT(events, testing::Contains(HasSubstr("frame skipped")));
  EXPECT_THAT(events.back(), HasSubstr("at last"));
}

TEST(SlamRun, StatsGetAColumnForEveryStageThatOccurs) {
  const auto path = scratch_path("slam_stats.csv");
  SlamStats stats(path);
  SlamUpdate update;
  update.times = {{"match", 1.0}};
  stats.add(update);
  update.times = {{"loop", 3.0}, {"match", 2.0}};
  stats.add(update);
  update.times = {{"match", 4.0}};
  stats.add(update);
  const auto lines = lines_of(path);
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_THAT(lines[0], testing::EndsWith(",match_ms,loop_ms"));
  EXPECT_THAT(lines[1], testing::EndsWith(",1.0000,"));
  EXPECT_THAT(lines[2], testing::EndsWith(",2.0000,3.0000"));
  EXPECT_THAT(lines[3], testing::EndsWith(",4.0000,"));
  for (const std::string& line : lines) EXPECT_EQ(split(line, ',').size(), split(lines[0], ',').size());
}

TEST(SlamRun, KeepsTheResultsOfAFaultyMethod) {
  FakeSource source(30);
  FakeSlam method;
  method.fault_at = 12;
  const SlamRunEnd end = slam_run(wired(source, method));
  EXPECT_TRUE(end.failure);
  EXPECT_EQ(end.result.ended, "fault: out of order");
  EXPECT_EQ(end.result.frames, 12);
  EXPECT_EQ(end.trajectory.size(), 12U);
  EXPECT_TRUE(end.map);
}

TEST(SlamRun, StopsWhenAskedAndFinishes) {
  FakeSource source(30);
  FakeSlam method;
  std::atomic<bool> stop = false;
  SlamRun run = wired(source, method);
  run.stop = &stop;
  run.progress = [&](const SlamProgress& progress) { stop = progress.done == 8; };
  const SlamRunEnd end = slam_run(run);
  EXPECT_TRUE(end.result.interrupted);
  EXPECT_EQ(end.result.frames, 8);
  EXPECT_EQ(method.finished, 1);
  EXPECT_FALSE(end.failure);
}

TEST(SlamRun, PutsMasksIntoFrames) {
  FakeSource source(4);
  FakeSlam method;
  SlamRun run = wired(source, method);
  GrayImage mask(32, 24);
  mask.at(3, 2) = 1;
  run.mask_of = [&](const Frame& frame) -> GrayView {
    if (frame.index == 3) throw Error("no mask for frame 3");
    return mask;
  };
  const SlamRunEnd end = slam_run(run);
  EXPECT_EQ(method.masked, 3);
  EXPECT_EQ(end.result.ended, "no mask for frame 3");
}

TEST(SlamRun, EndsBeforeItTakesMoreMemoryThanAllowedAndKeepsWhatItHas) {
  FakeSource source(4);
  FakeSlam method;
  SlamRun run = wired(source, method);
  run.max_memory_bytes = 1 << 20;  // less than any program has
  const SlamRunEnd end = slam_run(run);
  EXPECT_THAT(end.result.ended, HasSubstr("--max-memory"));
  EXPECT_TRUE(end.failure);
  EXPECT_EQ(end.trajectory.size(), 1U);
  EXPECT_EQ(method.finished, 1);
}

/// The last block pins what is below it.
TEST(SlamRun, WhatAFrameFreesIsGivenBackASecondLater) {
  if (sanitizes_memory) GTEST_SKIP() << "the allocator is another one";
  constexpr std::size_t block_bytes = 1000, blocks = 120000;
  constexpr std::int64_t frames = 30;
  FakeSource source(frames);
  FakeSlam method;
  SlamRun run = wired(source, method);
  std::unique_ptr<std::array<char, block_bytes>> last;
  double freed_mb = 0.0, later_mb = 0.0;
  run.progress = [&](const SlamProgress& progress) {
    if (progress.done == 2) {
      std::vector<std::unique_ptr<std::array<char, block_bytes>>> held(blocks);
      for (auto& block : held) (block = std::make_unique<std::array<char, block_bytes>>())->fill('x');
      last = std::move(held.back());
      held.clear();
      freed_mb = resident_memory_mb();
    }
    later_mb = resident_memory_mb();
  };
  slam_run(run);
  EXPECT_LT(later_mb, freed_mb - 90.0) << "of 120 MB";
}

TEST(SlamRun, ReportsDroppedFramesAndMapMemory) {
  FakeSource source(4);
  FakeSlam method;
  SlamResult result = slam_run(wired(source, method)).result;
  EXPECT_EQ(nlohmann::json::parse(to_json(result))["dropped_frames"], 0);
  EXPECT_EQ(nlohmann::json::parse(to_json(result))["map_memory_mb"], 2.5);
  EXPECT_FALSE(nlohmann::json::parse(to_json(result)).contains("map_memory_budget_mb"));
  method.dropped = 3;
  method.budget = 4'000'000;
  FakeSource again(4);
  result = slam_run(wired(again, method)).result;
  EXPECT_EQ(nlohmann::json::parse(to_json(result))["dropped_frames"], 3);
  EXPECT_EQ(nlohmann::json::parse(to_json(result))["map_memory_budget_mb"], 4);
  EXPECT_EQ(nlohmann::json::parse(to_json(result))["map_memory_measures"], "spared");
}

TEST(SlamRun, LeavesTheFinalMapInTheMapFile) {
  auto map = std::make_shared<Map>(make_test_map(3));
  map->keyframes[2].submap = 1;
  const auto file = scratch_path("slam_run.rastro");
  FakeSource source(4);
  FakeSlam method;
  method.given = map;
  GrowingMapFile map_file(file);
  SlamRun run = wired(source, method);
  run.map_file = &map_file;
  const SlamRunEnd end = slam_run(run);
  EXPECT_FALSE(end.failure);
  EXPECT_EQ(end.result.keyframes, 3);
  EXPECT_EQ(end.result.submaps, 2);
  EXPECT_TRUE(check_map_file(file).finished);
  EXPECT_EQ(load_map(file)->keyframes[2].submap, 1);
}

/// Only landmarks, without a camera: the map need not be of a known kind.
TEST(SlamRun, AnyMapIsLeftInTheMapFile) {
  const auto file = scratch_path("slam_run_any.rastro");
  FakeSource source(4);
  FakeSlam method;
  GrowingMapFile map_file(file);
  SlamRun run = wired(source, method);
  run.map_file = &map_file;
  const SlamRunEnd end = slam_run(run);
  EXPECT_FALSE(end.failure);
  ASSERT_TRUE(end.map);
  EXPECT_EQ(contradiction_in(*end.map), "");
  EXPECT_TRUE(check_map_file(file).finished);
  const auto kept = load_map(file);
  EXPECT_EQ(kept->method, "fake");
  EXPECT_EQ(kept->keyframes.size(), 2U);
  ASSERT_TRUE(kept->layer<LandmarkLayer>());
  EXPECT_EQ(kept->layer<LandmarkLayer>()->landmarks.size(), 3U);
  EXPECT_EQ(scale_of(*kept).origin, "wheels");
}

TEST(SlamResult, HasEverythingInJson) {
  FakeSource source(10);
  FakeSlam method;
  SlamRunEnd end = slam_run(wired(source, method));
  end.result.method.name = "fake";
  const auto json = nlohmann::json::parse(to_json(end.result));
  EXPECT_EQ(json["method"], "fake");
  EXPECT_EQ(json["frames"], 10);
  EXPECT_EQ(json["coverage"], 100);
  EXPECT_EQ(json["loops_closed"], 2);
  EXPECT_EQ(json["reasons"]["few_returns"], 1);
  EXPECT_EQ(json["stages"]["match"]["frames"], 10);
  EXPECT_NEAR(json["stages"]["loop"]["ms_mean"].get<double>(), 2.0, 1e-4);
  EXPECT_TRUE(json["stages"].contains("finish"));
  for (const auto& [name, value] : numbers_of(end.result)) EXPECT_TRUE(json.contains(name)) << name;
}

TEST(TrajectoryText, WritesStampsBeforeTheEpochToo) {
  EXPECT_THAT(tum_line({-1'500'000'000, {}}), testing::StartsWith("-1.500000000 0.000000000"));
  EXPECT_THAT(split_words(tum_line({976'052'857'337'530'001, {}}))[0], "976052857.337530001");
}

}  // namespace
}  // namespace rastro
