// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_sink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "rastro/cli/loss_advice.h"
#include "rastro/viewer/live_page_testing.h"

namespace rastro::cli {
namespace {

using rastro::testing::LivePage;

/// A method that only tells whether it maps.
class NoSlam : public Slam {
 public:
  SlamUpdate process(const Frame&) override { return {}; }
  Trajectory trajectory() const override { return {}; }
  std::shared_ptr<const Map> snapshot() const override { return nullptr; }
  void reset() override {}
  bool set_mapping(bool on) override {
    maps = on;
    return true;
  }
  bool maps = true;
};

/// Frames of a run in a thread of its own, one after the other, and a page that watches from the first on.
class WatchedRun {
 public:
  WatchedRun() {
    ::testing::internal::CaptureStderr();
    sink_.emplace(ServerFlags{"", "s3cret", 0}, LiveHello{"run", "none", 100, {LiveCommand::pause}}, method, true, 0);
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
  LiveSink& sink() { return *sink_; }

  NoSlam method;
  std::optional<LivePage> page;

 private:
  std::optional<LiveSink> sink_;
};

TEST(LiveSink, ShowsEachFrameAndSaysWhatToDo) {
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

TEST(LiveSink, PausesStepsAndGoesOn) {
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

TEST(LiveSink, AClosedPageLeavesAPausedRunToGoOn) {
  WatchedRun run;
  run.page->send(R"({"command":"pause"})");
  std::thread frames([&] {
    for (std::int64_t k = 0; k < 200; ++k) run.process(k);
  });
  run.page.reset();
  frames.join();  // returns
}

TEST(LiveSink, LocalizesOnlyWhenAsked) {
  WatchedRun run;
  run.page->send(R"({"command":"mapping_off"})");
  for (std::int64_t k = 0; run.method.maps && k < 10'000; ++k) run.process(k);
  EXPECT_FALSE(run.method.maps);
  run.page->send(R"({"command":"mapping_on"})");
  for (std::int64_t k = 0; !run.method.maps && k < 10'000'000; ++k) run.process(k);
  EXPECT_TRUE(run.method.maps);
}

TEST(LiveSink, SaysThatTheRunIsOver) {
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

TEST(LossAdvice, IsThereForEveryReasonThatSomethingCanBeDoneAbout) {
  for (int reason = static_cast<int>(SlamReason::no_data); reason <= static_cast<int>(SlamReason::implausible_motion);
       ++reason)
    EXPECT_NE(advice_for(static_cast<SlamReason>(reason)), "") << name_of(static_cast<SlamReason>(reason));
  EXPECT_EQ(advice_for(SlamReason::none), "");
}

}  // namespace
}  // namespace rastro::cli
