// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/pipeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <stdexcept>
#include <vector>

namespace rastro {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr TimeNs tenth = ns_per_second / 10;

/// A job that ends when it is released.
class Gate {
 public:
  std::function<int()> job(int result) {
    return [this, result] {
      opened_.wait();
      return result;
    };
  }
  void open() { open_.set_value(); }

 private:
  std::promise<void> open_;
  std::shared_future<void> opened_ = open_.get_future().share();
};

std::vector<int> due(Pipeline<int>& pipeline, const FrameTime& now) {
  std::vector<int> results;
  while (const auto result = pipeline.take_ready(now)) results.push_back(*result);
  return results;
}

std::function<int()> gives(int result) {
  return [result] { return result; };
}

class PipelineTest : public ::testing::TestWithParam<bool> {
 protected:
  PipelineOptions options() const { return {.own_thread = GetParam()}; }
};

TEST_P(PipelineTest, JobsRunAndResultsComeInTheOrderInWhichTheyAreGiven) {
  std::vector<int> order;  // declared first: jobs write into it until the pipeline ends
  Pipeline<int> pipeline(options());
  for (int k = 0; k < 100; ++k) {
    const auto job = [&order, k] {
      order.push_back(k);
      return 10 * k;
    };
    // A later result does not overtake an earlier one.
    EXPECT_TRUE(pipeline.submit(job, {k, 0}, {.frames = 200 - 2 * k}));
  }
  for (int k = 0; k < 100; ++k) EXPECT_EQ(pipeline.take_next(), 10 * k);
  EXPECT_FALSE(pipeline.take_next());
  ASSERT_EQ(order.size(), 100U);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(order[static_cast<std::size_t>(k)], k);
}

TEST_P(PipelineTest, ADelayInFramesIgnoresTheStamps) {
  Pipeline<int> pipeline(options());
  pipeline.submit(gives(7), {10, 5 * tenth}, {.frames = 3});
  EXPECT_FALSE(pipeline.empty());
  EXPECT_FALSE(pipeline.take_ready({12, 100 * tenth}));
  EXPECT_EQ(pipeline.take_ready({13, 0}), 7);  // a stamp that goes backward
  EXPECT_TRUE(pipeline.empty());
  EXPECT_FALSE(pipeline.take_ready({14, 0}));
}

TEST_P(PipelineTest, ADelayInTimeCountsByTheStampsAndNotBeforeItsFrame) {
  Pipeline<int> pipeline(options());
  const HandOverDelay delay{.frames = 2, .time = 3 * tenth, .max_extra_frames = 50};
  pipeline.submit(gives(1), {10, 5 * tenth}, delay);
  EXPECT_FALSE(pipeline.take_ready({11, 9 * tenth}));
  EXPECT_FALSE(pipeline.take_ready({12, 8 * tenth - 1}));
  EXPECT_EQ(pipeline.take_ready({12, 8 * tenth}), 1);
}

TEST_P(PipelineTest, WithConstantStampsOnlyFramesCount) {
  Pipeline<int> pipeline(options());
  pipeline.submit(gives(1), {10, tenth}, {.frames = 2, .time = 3 * tenth, .max_extra_frames = 5});
  for (std::int64_t frame = 11; frame < 17; ++frame) EXPECT_FALSE(pipeline.take_ready({frame, tenth}));
  EXPECT_EQ(pipeline.take_ready({17, tenth}), 1);
}

TEST_P(PipelineTest, AResultBehindALaterOneWaits) {
  Pipeline<int> pipeline(options());
  pipeline.submit(gives(1), {1, 0}, {.frames = 5});
  pipeline.submit(gives(2), {2, 0}, {.frames = 1});
  EXPECT_THAT(due(pipeline, {5, 0}), IsEmpty());
  EXPECT_THAT(due(pipeline, {6, 0}), ElementsAre(1, 2));
}

TEST_P(PipelineTest, AnExceptionIsThrownWhereTheResultIsTakenAndNoLaterJobRuns) {
  int ran = 0;
  Pipeline<int> pipeline(options());
  pipeline.submit([&ran] { return ++ran; }, {1, 0}, {});
  pipeline.submit([]() -> int { throw std::runtime_error("no room"); }, {1, 0}, {});
  pipeline.submit([&ran] { return ++ran; }, {1, 0}, {});
  EXPECT_EQ(pipeline.take_ready({2, 0}), 1);
  EXPECT_THROW(pipeline.take_ready({2, 0}), std::runtime_error);
  EXPECT_THROW(pipeline.take_ready({2, 0}), std::runtime_error);
  EXPECT_TRUE(pipeline.empty());
  EXPECT_THROW(pipeline.wait(), std::runtime_error);
  EXPECT_EQ(ran, 1);
}

TEST_P(PipelineTest, AnExceptionReachesALiveRunToo) {
  PipelineOptions live = options();
  live.hand_over = HandOver::when_ready;
  Pipeline<int> pipeline(live);
  pipeline.submit([]() -> int { throw std::runtime_error("no room"); }, {1, 0}, {});
  pipeline.submit(gives(2), {1, 0}, {});
  EXPECT_THROW(pipeline.wait(), std::runtime_error);
  EXPECT_THROW(pipeline.take_ready({1, 0}), std::runtime_error);
  EXPECT_THROW(pipeline.take_ready({1, 0}), std::runtime_error);
}

TEST_P(PipelineTest, WaitingKeepsResultsAndDiscardingDropsThem) {
  int ran = 0;
  Pipeline<int> pipeline(options());
  const auto job = [&ran] { return ++ran; };
  pipeline.submit(job, {1, 0}, {.frames = 9});
  pipeline.wait();
  EXPECT_EQ(ran, 1);
  EXPECT_FALSE(pipeline.empty());
  EXPECT_EQ(pipeline.take_next(), 1);
  pipeline.submit(job, {2, 0}, {});
  pipeline.discard();
  EXPECT_TRUE(pipeline.empty());
  pipeline.submit(job, {3, 0}, {});
  EXPECT_EQ(pipeline.take_next(), 3);
  EXPECT_EQ(pipeline.statistics().jobs, 3);
  EXPECT_EQ(pipeline.statistics().handed_over, 2);
}

TEST_P(PipelineTest, ResultsNeedNotBeCopied) {
  Pipeline<std::unique_ptr<int>> pipeline(options());
  pipeline.submit([] { return std::make_unique<int>(5); }, {1, 0}, {});
  const auto result = pipeline.take_next();
  ASSERT_TRUE(result);
  EXPECT_EQ(**result, 5);
}

/// A front end that submits a job at some frames, with stamps that do not increase in between, and records when it got
/// which result.
std::vector<std::pair<std::int64_t, int>> hand_over_points(bool own_thread) {
  Pipeline<int> pipeline({.own_thread = own_thread});
  std::vector<std::pair<std::int64_t, int>> points;
  for (std::int64_t frame = 1; frame <= 200; ++frame) {
    const FrameTime now{frame, tenth * (frame < 80 || frame > 120 ? frame : 80)};
    while (const auto result = pipeline.take_ready(now)) points.emplace_back(frame, *result);
    if (frame % 7 != 0 && frame % 11 != 0) continue;
    const int work = static_cast<int>(frame * 7919 % 5000);
    const auto job = [work] {
      int sum = 0;
      for (int i = 0; i < work; ++i) sum = (sum * 31 + i) % 65521;
      return sum;
    };
    pipeline.submit(job, now, {.frames = 2, .time = (frame % 3) * 4 * tenth, .max_extra_frames = 15});
  }
  return points;
}

TEST(Pipeline, HandsOverAtTheSameFramesWithAThreadAndWithout) {
  const auto alone = hand_over_points(false);
  EXPECT_GT(alone.size(), 40U);
  for (int repeat = 0; repeat < 5; ++repeat) EXPECT_EQ(hand_over_points(true), alone);
}

TEST(Pipeline, AFixedDelayWaitsForLateResults) {
  Gate gate;
  Pipeline<int> pipeline({.own_thread = true});
  pipeline.submit(gate.job(3), {1, 0}, {.frames = 2});
  EXPECT_FALSE(pipeline.take_ready({2, 0}));
  gate.open();
  EXPECT_EQ(pipeline.take_ready({3, 0}), 3);
  EXPECT_GE(pipeline.statistics().wait_ms, 0.0);
  EXPECT_EQ(pipeline.statistics().postponed, 0);
}

TEST(Pipeline, ALiveRunTakesReadyResultsAndNeverWaits) {
  Gate gate;
  Pipeline<int> pipeline({.own_thread = true, .hand_over = HandOver::when_ready});
  pipeline.submit(gate.job(1), {1, 0}, {.frames = 3});
  pipeline.submit(gives(2), {2, 0}, {.frames = 3});
  EXPECT_THAT(due(pipeline, {3, 0}), IsEmpty());
  EXPECT_EQ(pipeline.statistics().postponed, 0);
  for (std::int64_t frame = 4; frame < 9; ++frame) EXPECT_THAT(due(pipeline, {frame, 0}), IsEmpty());
  EXPECT_EQ(pipeline.statistics().postponed, 1);
  gate.open();
  pipeline.wait();
  EXPECT_THAT(due(pipeline, {9, 0}), ElementsAre(1, 2));
  // Ready before its fixed delay.
  pipeline.submit(gives(3), {9, 0}, {.frames = 100, .time = 1000 * tenth});
  pipeline.wait();
  EXPECT_EQ(pipeline.take_ready({9, 0}), 3);
  EXPECT_EQ(pipeline.statistics().postponed, 1);
}

TEST(Pipeline, ALiveRunIsSettledOnceTheDelayHasPassedHoweverFastTheJobWas) {
  for (const HandOver hand_over : {HandOver::when_ready, HandOver::fixed_delay}) {
    Pipeline<int> pipeline({.own_thread = true, .hand_over = hand_over});
    EXPECT_TRUE(pipeline.settled({0, 0}));
    pipeline.submit(gives(1), {10, 0}, {.frames = 2, .time = 3 * tenth, .max_extra_frames = 9});
    pipeline.wait();
    pipeline.take_ready({11, tenth});
    EXPECT_EQ(pipeline.empty(), hand_over == HandOver::when_ready);
    EXPECT_FALSE(pipeline.settled({11, tenth}));
    EXPECT_FALSE(pipeline.settled({12, 3 * tenth - 1}));
    pipeline.take_ready({12, 3 * tenth});
    EXPECT_TRUE(pipeline.settled({12, 3 * tenth}));
  }
}

TEST(Pipeline, ALateJobIsNotSettledBeforeItsResultIsTaken) {
  Gate gate;
  Pipeline<int> pipeline({.own_thread = true, .hand_over = HandOver::when_ready});
  pipeline.submit(gate.job(1), {1, 0}, {.frames = 2});
  EXPECT_FALSE(pipeline.settled({20, 0}));
  gate.open();
  pipeline.wait();
  EXPECT_EQ(pipeline.take_ready({20, 0}), 1);
  EXPECT_TRUE(pipeline.settled({20, 0}));
}

TEST(Pipeline, ALiveRunDropsJobsBeyondMaxInFlight) {
  Gate gate;
  Pipeline<int> pipeline({.own_thread = true, .hand_over = HandOver::when_ready, .max_in_flight = 2});
  EXPECT_TRUE(pipeline.submit(gate.job(1), {1, 0}, {}));
  EXPECT_TRUE(pipeline.submit(gives(2), {1, 0}, {}));
  EXPECT_FALSE(pipeline.submit(gives(3), {1, 0}, {}));
  EXPECT_FALSE(pipeline.accepts()) << "which counts as well";
  gate.open();
  pipeline.wait();
  EXPECT_THAT(due(pipeline, {1, 0}), ElementsAre(1, 2));
  EXPECT_TRUE(pipeline.accepts());
  EXPECT_TRUE(pipeline.submit(gives(4), {2, 0}, {}));
  EXPECT_EQ(pipeline.take_next(), 4);
  EXPECT_EQ(pipeline.statistics().dropped, 2);
  EXPECT_EQ(pipeline.statistics().jobs, 3);
}

INSTANTIATE_TEST_SUITE_P(Modes, PipelineTest, ::testing::Bool(),
                         [](const auto& mode) { return mode.param ? "OwnThread" : "AtOnce"; });

}  // namespace
}  // namespace rastro
