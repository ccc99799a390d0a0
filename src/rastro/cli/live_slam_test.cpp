// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_slam.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <thread>

#include "rastro/cli/live_odometry.h"
#include "rastro/cli/live_tracks.h"
#include "rastro/cli/loss_advice.h"
#include "rastro/map/file/map_file.h"
#include "rastro/viewer/live_page_testing.h"

namespace rastro::cli {
namespace {

/// Removed at the end.
struct OwnFolder {
  OwnFolder() : path(std::filesystem::temp_directory_path() / fmt::format("rastro_live_{}", ::getpid())) {
    std::filesystem::create_directories(path);
  }
  ~OwnFolder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
};

/// A method that only tells whether it maps.
class NoSlam : public Slam {
 public:
  SlamUpdate process(const Frame&) override { return {}; }
  Trajectory trajectory() const override { return {}; }
  std::shared_ptr<const Map> snapshot() const override { return map; }
  void reset() override { map = nullptr; }
  bool set_mapping(bool on) override {
    maps = on;
    return true;
  }
  bool maps = true;
  std::shared_ptr<const Map> map;
};

/// Frames of a run in a thread of its own, one after the other, and a page that watches from the first on.
class WatchedRun {
 public:
  WatchedRun() {
    ::testing::internal::CaptureStderr();
    sink_.emplace(ServerFlags{"", "s3cret", 0}, LiveHello{"run", "none", 100, {}}, method, true, folder.path, 0);
    const std::string said = ::testing::internal::GetCapturedStderr();
    page.emplace(static_cast<std::uint16_t>(std::stoi(said.substr(said.rfind(':') + 1))), "/live?token=s3cret");
    page->next_of("hello");
  }
  void process(std::int64_t index, SlamState state = SlamState::tracking, SlamReason reason = SlamReason::none) {
    SlamUpdate update;
    update.index = index;
    update.state = state;
    update.reason = reason;
    Frame frame;
    frame.index = index;
    sink_->show({index + 1, 100, 0, &update, &frame});
  }
  LiveSlam& sink() { return *sink_; }

  OwnFolder folder;
  NoSlam method;
  std::optional<LivePage> page;

 private:
  std::optional<LiveSlam> sink_;
};

TEST(LiveSlam, ShowsEachFrameAndSaysWhatToDo) {
  WatchedRun run;
  run.process(0);
  run.process(1, SlamState::lost, SlamReason::blurred);
  const auto first = run.page->next_of("frame"), second = run.page->next_of("frame");
  EXPECT_EQ(first["index"], 0);
  EXPECT_FALSE(first.contains("advice"));
  EXPECT_EQ(second["reason"], "blurred");
  EXPECT_EQ(second["advice"], advice_for(SlamReason::blurred));
  EXPECT_TRUE(second["pose"].is_null()) << "a lost frame has none";
}

TEST(LiveSlam, PausesStepsAndGoesOn) {
  WatchedRun run;
  run.page->send(R"({"command":"pause"})");
  std::atomic<std::int64_t> processed = 0;
  std::thread frames([&] {
    for (std::int64_t k = 0; k < 1000; ++k) {
      run.process(k);
      processed = k + 1;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  while (run.page->next_of("status")["paused"] != true) {
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::int64_t paused_at = processed;
  EXPECT_LT(paused_at, 1000);
  run.page->send(R"({"command":"step"})");
  while (processed == paused_at) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(processed, paused_at + 1) << "one frame and no more";
  run.page->send(R"({"command":"resume"})");
  frames.join();
  EXPECT_EQ(processed, 1000);
}

TEST(LiveSlam, AClosedPageLeavesAPausedRunToGoOn) {
  WatchedRun run;
  run.page->send(R"({"command":"pause"})");
  std::thread frames([&] {
    for (std::int64_t k = 0; k < 200; ++k) run.process(k);
  });
  run.page.reset();
  frames.join();  // returns
}

TEST(LiveSlam, LocalizesOnlyWhenAsked) {
  WatchedRun run;
  run.page->send(R"({"command":"mapping_off"})");
  for (std::int64_t k = 0; run.method.maps && k < 10'000; ++k) run.process(k);
  EXPECT_FALSE(run.method.maps);
  run.page->send(R"({"command":"mapping_on"})");
  for (std::int64_t k = 0; !run.method.maps && k < 10'000'000; ++k) run.process(k);
  EXPECT_TRUE(run.method.maps);
}

std::shared_ptr<const Map> map_of_one_keyframe() {
  auto map = std::make_shared<Map>();
  map->method = "none";
  map->cameras.emplace_back().intrinsics = camera_from_field_of_view(60.0, 64, 48);
  map->sessions.emplace_back();
  map->keyframes.emplace_back();
  return map;
}

/// Sends a command and processes frames until the run says something.
std::string answer_to(WatchedRun& run, const std::string& command) {
  run.page->send(command);
  for (std::int64_t k = 0;; ++k) {
    run.process(k);
    const auto message = run.page->next_text();
    if (message["type"] == "status" && message["line"] != "") return message["line"];
  }
}

TEST(LiveSlam, SavesTheMapAndBeginsAnother) {
  WatchedRun run;
  const auto saved = [&run](const char* name) { return run.folder.path / name; };
  EXPECT_EQ(answer_to(run, R"({"command":"save"})"), "there is no map yet");
  run.method.map = map_of_one_keyframe();
  EXPECT_THAT(answer_to(run, R"({"command":"save"})"), ::testing::EndsWith("map_0001.rastro"));
  EXPECT_EQ(load_map(saved("map_0001.rastro"))->keyframes.size(), 1U);
  EXPECT_THAT(answer_to(run, R"({"command":"reset"})"), ::testing::EndsWith("map_0002.rastro"));
  EXPECT_EQ(load_map(saved("map_0002.rastro"))->keyframes.size(), 1U);
  EXPECT_EQ(run.page->next_of("status")["resets"], 1);
  EXPECT_EQ(run.method.map, nullptr);
}

TEST(LiveSlam, KeepsTheMapThatCannotBeSaved) {
  WatchedRun run;
  run.method.map = map_of_one_keyframe();
  std::filesystem::remove_all(run.folder.path);
  EXPECT_THAT(answer_to(run, R"({"command":"reset"})"), ::testing::StartsWith("the map was not saved: "));
  EXPECT_NE(run.method.map, nullptr);
}

TEST(LiveSlam, SaysThatTheRunIsOver) {
  WatchedRun run;
  SlamRunEnd end;
  end.result.frames = 240;
  end.result.coverage = 100.0;
  run.sink().finish(end);
  for (;;) {
    const auto status = run.page->next_of("status");
    if (status["ended"] != true) continue;
    EXPECT_THAT(status["line"].get<std::string>(), ::testing::HasSubstr("240 frames, 100.0 %"));
    break;
  }
  run.page.reset();
  run.sink().wait_until_closed();  // returns
}

/// Of a sink of any run: what the page sees.
template <typename Sink, typename... Rest>
LivePage page_of(std::optional<Sink>& sink, const Rest&... rest) {
  ::testing::internal::CaptureStderr();
  sink.emplace(ServerFlags{"", "s3cret", 0}, LiveHello{"run", "none", 100, {}}, rest...);
  const std::string said = ::testing::internal::GetCapturedStderr();
  return LivePage(static_cast<std::uint16_t>(std::stoi(said.substr(said.rfind(':') + 1))), "/live?token=s3cret");
}

TEST(LiveTracks, ShowTheFeaturesWithTheirTrails) {
  std::optional<LiveTracks> sink;
  LivePage page = page_of(sink);
  EXPECT_EQ(page.next_of("hello")["poses"], false);
  TrackFrame seen;
  seen.health = TrackHealth::dark_or_blank;
  seen.features = {{.id = 5, .pixel = {3.0F, 2.0F}, .state = TrackState::tracked},
                   {.id = 8, .pixel = {4.0F, 2.0F}, .state = TrackState::reidentified}};
  sink->write(seen, GrayImage(16, 16).view());
  const auto frame = page.next_of("frame");
  EXPECT_EQ(frame["reason"], name_of(TrackHealth::dark_or_blank));
  EXPECT_EQ(frame["advice"], advice_for(TrackHealth::dark_or_blank));
  const auto image = page.next_block();
  EXPECT_EQ(image["feature_state_names"], nlohmann::json({"matched", "new", "re_identified"}));
  EXPECT_EQ(image["feature_ids"]["count"], 2);
  EXPECT_EQ(image["trail_lengths"]["count"], 2);
}

/// Moves ahead, frame by frame.
class NoOdometry : public Odometry {
 public:
  OdometryUpdate process(const Frame&) override { return {}; }
  Trajectory trajectory() const override { return {}; }
  std::vector<OdometryFeature> features() const override { return {{{3.0F, 4.0F}, 7, OdometryFeature::State::inlier}}; }
};

TEST(LiveOdometry, ShowsPosesFeaturesAndTheFinalTrajectory) {
  const NoOdometry method;
  std::optional<LiveOdometry> sink;
  LivePage page = page_of(sink, method);
  EXPECT_EQ(page.next_of("hello")["poses"], true);
  EXPECT_EQ(page.next_of("scene")["revision"], 0) << "which way is up";
  Frame frame;
  frame.image = GrayImage(16, 16);
  OdometryUpdate update;
  update.state = OdometryState::lost;
  update.reason = OdometryReason::few_inliers;
  sink->show(frame, update);
  EXPECT_EQ(page.next_of("frame")["advice"], advice_for(OdometryReason::few_inliers));
  EXPECT_EQ(page.next_block()["features"]["count"], 2);
  OdometryRunEnd end;
  end.trajectory = {{0, SE3()}};
  sink->finish(end);
  EXPECT_EQ(page.next_of("scene")["revision"], 1);
  EXPECT_EQ(page.next_of("status")["ended"], true);
}

TEST(LossAdvice, IsThereForEveryReasonThatSomethingCanBeDoneAbout) {
  for (int reason = static_cast<int>(SlamReason::no_data); reason <= static_cast<int>(SlamReason::uncertain_scale);
       ++reason)
    EXPECT_NE(advice_for(static_cast<SlamReason>(reason)), "") << name_of(static_cast<SlamReason>(reason));
  EXPECT_EQ(advice_for(SlamReason::none), "");
}

}  // namespace
}  // namespace rastro::cli
