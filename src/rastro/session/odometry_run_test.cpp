// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/odometry_run.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "rastro/base/append_file.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/session/fakes_testing.h"
#include "rastro/session/run_loop.h"
#include "rastro/session/trajectory_text.h"

namespace rastro {
namespace {

/// Reports scripted states; moves one unit along x per frame.
class FakeOdometry : public Odometry {
 public:
  struct Saying {
    OdometryState state = OdometryState::tracking;
    OdometryReason reason = OdometryReason::none;
    bool used = true;
    std::string detail;
  };
  explicit FakeOdometry(std::vector<Saying> sayings) : sayings_(std::move(sayings)) {}

  OdometryUpdate process(const Frame& frame) override {
    const std::size_t number = poses_.size();
    if (number == fail_at) throw std::runtime_error("it is broken");
    const Saying saying = number < sayings_.size() ? sayings_[number] : Saying();
    OdometryUpdate update;
    update.index = frame.index;
    update.stamp = frame.stamp;
    update.state = saying.state, update.reason = saying.reason, update.used = saying.used;
    update.detail = saying.detail;
    update.world_from_camera = SE3(SO3(), {static_cast<double>(number), 0.0, 0.0});
    update.milliseconds = 2.0;
    poses_.push_back({frame.stamp, update.world_from_camera});
    return update;
  }
  Trajectory trajectory() const override { return poses_; }

  std::size_t fail_at = 1'000'000;

 private:
  std::vector<Saying> sayings_;
  Trajectory poses_;
};

using State = OdometryState;
using Reason = OdometryReason;

std::vector<FakeOdometry::Saying> all_states() {
  return {{State::initializing, Reason::first_frame, false, ""},
          {State::initializing, Reason::too_little_parallax, false, ""},
          {State::tracking, Reason::none, true, ""},
          {State::tracking, Reason::none, true, ""},
          {State::weak, Reason::few_inliers, true, "9 inliers, need 15"},
          {State::weak, Reason::few_inliers, true, "8 inliers, need 15"},
          {State::lost, Reason::few_inliers, true, ""},
          {State::tracking, Reason::none, true, ""}};
}

TEST(OdometryRun, CountsFramesStatesAndReasons) {
  FakeSource source(9, {4});
  FakeOdometry method(all_states());
  OdometryRun run;
  run.source = &source, run.method = &method, run.frames_asked = 10;
  const OdometryRunEnd end = odometry_run(run);
  EXPECT_FALSE(end.failure);
  EXPECT_EQ(end.result.ended, "end of data");
  EXPECT_FALSE(end.result.interrupted);
  EXPECT_EQ(end.result.frames, 8);
  EXPECT_EQ(end.result.skipped_frames, 1);
  EXPECT_NE(end.first_skip.find("frame 4"), std::string::npos);
  EXPECT_EQ(end.result.initializing, 2);
  EXPECT_EQ(end.result.tracking, 3);
  EXPECT_EQ(end.result.weak, 2);
  EXPECT_EQ(end.result.lost, 1);
  EXPECT_EQ(end.result.unused_frames, 2);
  const std::map<std::string, std::int64_t> reasons = {
      {"few_inliers", 3}, {"first_frame", 1}, {"too_little_parallax", 1}};
  EXPECT_EQ(end.result.reasons, reasons);
  EXPECT_DOUBLE_EQ(end.result.coverage, 80.0);
  EXPECT_EQ(end.trajectory.size(), 8U);
  EXPECT_DOUBLE_EQ(end.result.ms_per_frame_mean, 2.0);
  EXPECT_NEAR(end.result.ms_per_frame_p95, 2.0, 0.02);
  EXPECT_GT(end.result.peak_memory_mb, 1.0);
}

TEST(OdometryRun, WithoutANumberAskedForSkippedFramesCountAsAsked) {
  FakeSource source(5, {1});
  FakeOdometry method({});
  OdometryRun run;
  run.source = &source, run.method = &method;
  EXPECT_DOUBLE_EQ(odometry_run(run).result.coverage, 80.0);
  FakeSource empty(0);
  run.source = &empty;
  FakeOdometry nothing({});
  run.method = &nothing;
  EXPECT_EQ(odometry_run(run).result.coverage, 0.0);
}

TEST(OdometryRun, ReportsEveryFrameToTheWatcher) {
  FakeSource source(5, {1}, 100, 2);
  FakeOdometry method({});
  OdometryRun run;
  run.source = &source, run.method = &method, run.frames_asked = 5;
  source = FakeSource(5, {102}, 100, 2);
  std::vector<std::int64_t> done, watched;
  run.progress = [&](const OdometryProgress& progress) {
    done.push_back(progress.done);
    EXPECT_EQ(progress.frames, 5);
    EXPECT_EQ(progress.last->index, watched.back());
  };
  run.watch = [&](const Frame& frame, const OdometryUpdate& update) {
    EXPECT_EQ(frame.index, update.index);
    watched.push_back(update.index);
  };
  odometry_run(run);
  EXPECT_EQ(watched, (std::vector<std::int64_t>{100, 104, 106, 108}));
  EXPECT_EQ(done, (std::vector<std::int64_t>{1, 3, 4, 5})) << "those that were skipped are done, too";
}

TEST(OdometryRun, WritesPosesAsFirstGivenAndEachChangeOfStateAsAnEvent) {
  const auto path = scratch_path("odometry");
  FakeSource source(8);
  FakeOdometry method(all_states());
  {
    RunFolder folder(path, false);
    OdometryRun run;
    run.source = &source, run.method = &method, run.folder = &folder;
    odometry_run(run);
  }
  std::vector<nlohmann::json> events;
  const std::string text = read_whole_file(path / "events.jsonl");
  for (std::size_t begin = 0; begin < text.size(); begin = text.find('\n', begin) + 1)
    events.push_back(nlohmann::json::parse(text.substr(begin, text.find('\n', begin) - begin)));
  ASSERT_EQ(events.size(), 6U) << text;
  EXPECT_NE(events[3].dump().find("few_inliers: 9 inliers, need 15"), std::string::npos) << text;
  EXPECT_NE(events[4].dump().find("lost"), std::string::npos) << text;
  EXPECT_EQ(events[4].dump().find("few_inliers:"), std::string::npos) << "no detail, no colon";
  const std::string online = read_whole_file(path / "trajectory_online.txt");
  for (const StampedPose& pose : method.trajectory())
    EXPECT_NE(online.find(tum_line(pose)), std::string::npos) << pose.stamp;
  const std::string stats = read_whole_file(path / "stats.csv");
  EXPECT_EQ(std::count(stats.begin(), stats.end(), '\n'), 9) << "a header and a row a frame";
}

TEST(OdometryRun, AFaultEndsItAndKeepsTheResultsSoFar) {
  FakeSource source(8);
  FakeOdometry method({});
  method.fail_at = 3;
  OdometryRun run;
  run.source = &source, run.method = &method;
  const OdometryRunEnd end = odometry_run(run);
  EXPECT_TRUE(end.failure);
  EXPECT_EQ(end.result.ended, "fault: it is broken");
  EXPECT_EQ(end.result.frames, 3);
  EXPECT_EQ(end.trajectory.size(), 3U);
}

TEST(OdometryRun, EndsAfterTheCurrentFrameWhenAskedTo) {
  FakeSource source(8);
  FakeOdometry method({});
  std::atomic<bool> stop = false;
  OdometryRun run;
  run.source = &source, run.method = &method, run.stop = &stop;
  run.watch = [&](const Frame& frame, const OdometryUpdate&) { stop = frame.index == 2; };
  const OdometryRunEnd end = odometry_run(run);
  EXPECT_TRUE(end.result.interrupted);
  EXPECT_EQ(end.result.ended, "interrupted");
  EXPECT_EQ(end.result.frames, 3);
  EXPECT_FALSE(end.failure);
}

TEST(OdometryResult, JsonHasItsNumbersRounded) {
  OdometryResult result;
  result.frames = 7, result.tracking = 5, result.lost = 2;
  result.coverage = 33.33333, result.path_length = 1.23456;
  result.reasons = {{"blurred", 2}};
  result.ended = "end of data";
  const auto json = nlohmann::json::parse(to_json(result));
  EXPECT_EQ(json.at("frames"), 7);
  EXPECT_EQ(json.at("coverage"), 33.3333);
  EXPECT_EQ(json.at("path_length"), 1.2346);
  EXPECT_EQ(json.at("reasons").at("blurred"), 2);
  EXPECT_EQ(json.at("lost"), 2);
  EXPECT_EQ(json.at("scale"), "relative");
  EXPECT_EQ(json.at("interrupted"), false);
}

TEST(RunGuarded, TheFirstFailureIsKept) {
  RunLoopEnd end;
  run_guarded(end, [] {});
  EXPECT_FALSE(end.failure);
  EXPECT_EQ(end.ended, "end of data");
  run_guarded(end, [] { throw std::runtime_error("first"); });
  run_guarded(end, [] { throw std::runtime_error("second"); });
  EXPECT_EQ(end.ended, "fault: first");
}

}  // namespace
}  // namespace rastro
