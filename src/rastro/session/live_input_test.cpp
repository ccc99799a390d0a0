// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/live_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <nlohmann/json.hpp>

#include "rastro/base/append_file.h"
#include "rastro/base/clock_testing.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/session/live_statistics_json.h"

namespace rastro {
namespace {

using testing::HasSubstr;

constexpr TimeNs ms = 1'000'000;

/// What a scripted source does next: a frame, or a condition, or an error.
struct Step {
  std::optional<LiveCondition> condition;
  std::string error;
  bool is_unusable = false;
};

/// Does its steps one after the other, then ends. `go`: waited for after the first step. `done` is set at the end.
class ScriptedSource final : public LiveSource {
 public:
  ScriptedSource(std::vector<Step> steps, FakeClock& clock, std::promise<void>* go = nullptr,
                 std::promise<void>* done = nullptr)
      : steps_(std::move(steps)), clock_(clock), go_(go), done_(done) {}

  const SourceInfo& info() const override { return info_; }

  std::optional<ArrivedFrame> next(TimeNs) override {
    if (at_ == steps_.size()) {
      condition_ = {LiveState::ended, ""};
      if (done_) std::exchange(done_, nullptr)->set_value();
      return std::nullopt;
    }
    if (at_ == 1 && go_) go_->get_future().wait();
    const Step& step = steps_[at_++];
    if (step.condition) {
      condition_ = *step.condition;
      return std::nullopt;
    }
    if (step.is_unusable) throw UnusableSource(step.error);
    if (!step.error.empty()) throw Error(step.error);
    condition_ = {};
    ArrivedFrame arrived;
    arrived.frame.index = frames_++;
    arrived.frame.image = GrayImage(8, 6);
    arrived.exposed = clock_.now();
    return arrived;
  }

  LiveCondition condition() const override { return condition_; }

 private:
  std::vector<Step> steps_;
  FakeClock& clock_;
  std::promise<void>*go_, *done_;
  SourceInfo info_;
  LiveCondition condition_;
  std::size_t at_ = 0;
  std::int64_t frames_ = 0;
};

std::vector<std::int64_t> read_all(LiveInput& input) {
  std::vector<std::int64_t> indices;
  while (const auto frame = input.next()) indices.push_back(frame->index);
  return indices;
}

TEST(LiveInput, DropsTheOldestAndCountsThem) {
  FakeClock clock;
  std::promise<void> go, done;
  std::atomic<int> tapped = 0;
  LiveInputOptions options;
  options.queue = 3;
  options.tap = [&](const Frame&) { ++tapped; };
  LiveInput input(std::make_unique<ScriptedSource>(std::vector<Step>(10), clock, &go, &done), clock, options);
  // The method works on the first frame until all others have come.
  EXPECT_EQ(input.next()->index, 0);
  go.set_value();
  done.get_future().wait();
  EXPECT_EQ(read_all(input), (std::vector<std::int64_t>{7, 8, 9}));
  const LiveStatistics statistics = input.statistics();
  EXPECT_EQ(statistics.arrived, 10);
  EXPECT_EQ(statistics.dropped, 6);
  EXPECT_EQ(tapped.load(), 10) << "a recorder gets dropped frames too";
  EXPECT_EQ(json_of(statistics)["dropped_because"]["method_too_slow"], 6);
  EXPECT_THAT(summary_of(statistics), HasSubstr("6 of 10 frames dropped (the method was too slow)"));
}

TEST(LiveInput, MeasuresFromExposureToPose) {
  FakeClock clock;
  LiveInput input(std::make_unique<ScriptedSource>(std::vector<Step>(1), clock), clock, {});
  ASSERT_TRUE(input.next());
  clock.move(20 * ms);
  input.note_pose();
  clock.move(500 * ms);
  input.note_pose();  // counted once
  EXPECT_FALSE(input.next());
  EXPECT_EQ(input.statistics().exposure_to_pose.count(), 1);
  EXPECT_NEAR(input.statistics().exposure_to_pose.percentile_ms(0.5), 20.0, 0.2);
}

TEST(LiveInput, SaysThatItsSourceDiedAndReturned) {
  FakeClock clock;
  RunFolder folder(scratch_path("live_input"), false);
  std::vector<Step> steps;
  for (int k = 0; k < 20; ++k) {
    steps.push_back({});
    steps.push_back({LiveCondition{LiveState::stalled, "no frame for 2 s"}, "", false});
    steps.push_back({LiveCondition{LiveState::gone, "camera unplugged; waiting for it"}, "", false});
    steps.push_back({LiveCondition{LiveState::gone, "camera unplugged; waiting for it"}, "", false});
  }
  steps.push_back({});
  LiveInputOptions options;
  options.queue = 100;
  LiveInput input(std::make_unique<ScriptedSource>(steps, clock), clock, options);
  input.set_folder(&folder);
  EXPECT_EQ(read_all(input).size(), 21U) << "it goes on";
  EXPECT_EQ(input.statistics().stalls, 20);
  EXPECT_EQ(input.statistics().losses, 20);
  const std::string events = read_whole_file(folder.file("events.jsonl"));
  EXPECT_THAT(events, HasSubstr("camera unplugged; waiting for it"));
  EXPECT_THAT(events, HasSubstr("source back"));
}

TEST(LiveInput, BrokenFramesAreErrorsInTheirOrderAndAnUnusableSourceEnds) {
  FakeClock clock;
  LiveInput input(
      std::make_unique<ScriptedSource>(
          std::vector<Step>{{}, {std::nullopt, "broken", false}, {}, {std::nullopt, "size", true}, {}}, clock),
      clock, {});
  EXPECT_EQ(input.next()->index, 0);
  EXPECT_THROW(input.next(), Error);
  EXPECT_EQ(input.next()->index, 1);
  EXPECT_THROW(input.next(), UnusableSource);
  EXPECT_FALSE(input.next());
}

/// Gives no frame and never ends.
class SilentSource final : public LiveSource {
 public:
  explicit SilentSource(Clock& clock) : clock_(clock) {}
  const SourceInfo& info() const override { return info_; }
  std::optional<ArrivedFrame> next(TimeNs patience) override {
    clock_.sleep_for(patience);
    return std::nullopt;
  }
  LiveCondition condition() const override { return {LiveState::gone, "unplugged"}; }

 private:
  Clock& clock_;
  SourceInfo info_;
};

TEST(LiveInput, StopsWhileItWaits) {
  SteadyClock clock;
  std::atomic<bool> stop = false;
  LiveInputOptions options;
  options.stop = &stop;
  std::string said;
  options.idle = [&](const LiveCondition& condition) {
    said = condition.line;
    stop = !said.empty();
  };
  LiveInput input(std::make_unique<SilentSource>(clock), clock, options);
  const TimeNs begin = clock.now();
  EXPECT_FALSE(input.next());
  EXPECT_TRUE(input.was_stopped());
  EXPECT_EQ(said, "unplugged");
  EXPECT_LT(clock.now() - begin, ns_per_second);
}

TEST(LiveInput, GivesWhatWaitsAlsoOnceStoppedWhereItIsToDrain) {
  for (const bool drains : {true, false}) {
    FakeClock clock;
    std::promise<void> go, done;
    std::atomic<bool> stop = false;
    LiveInputOptions options;
    options.stop = &stop;
    options.drains = drains;
    LiveInput input(std::make_unique<ScriptedSource>(std::vector<Step>(6), clock, &go, &done), clock, options);
    EXPECT_EQ(input.next()->index, 0);
    go.set_value();
    done.get_future().wait();  // all others wait
    stop = true;
    EXPECT_EQ(read_all(input), drains ? (std::vector<std::int64_t>{1, 2, 3, 4, 5}) : std::vector<std::int64_t>{});
    EXPECT_TRUE(input.was_stopped());
    EXPECT_FALSE(input.next());
  }
}

/// Gives a frame each time, and stops the input while it makes the third.
class StoppingSource final : public LiveSource {
 public:
  explicit StoppingSource(std::atomic<bool>& stop) : stop_(stop) {}
  const SourceInfo& info() const override { return info_; }
  std::optional<ArrivedFrame> next(TimeNs) override {
    ArrivedFrame arrived;
    arrived.frame.index = frames_++;
    if (frames_ == 3) stop_ = true;
    return arrived;
  }
  LiveCondition condition() const override { return {}; }

 private:
  std::atomic<bool>& stop_;
  SourceInfo info_;
  std::int64_t frames_ = 0;
};

TEST(LiveInput, TakesNoFurtherFramesOnceStoppedWhereItIsToDrain) {
  SteadyClock clock;
  std::atomic<bool> stop = false;
  LiveInputOptions options;
  options.stop = &stop;
  options.drains = true;
  LiveInput input(std::make_unique<StoppingSource>(stop), clock, options);
  EXPECT_EQ(read_all(input), (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(input.statistics().arrived, 2) << "what is not given is not counted either";
}

}  // namespace
}  // namespace rastro
