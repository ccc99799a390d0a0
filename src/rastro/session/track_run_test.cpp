// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/track_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "rastro/base/scratch_testing.h"
#include "rastro/session/fakes_testing.h"

namespace rastro {
namespace {

/// One run with fakes; its parts may be changed before go().
struct Trial {
  explicit Trial(FakeSource source_to_use) : source(std::move(source_to_use)) {
    run.source = &source;
    run.process = [this](GrayView image, TimeNs stamp, GrayView mask) { return tracker.process(image, stamp, mask); };
    run.sinks = {&sink};
    run.image_sinks = {&image_sink};
  }
  TrackRunEnd go() { return track_run(run); }

  FakeSource source;
  FakeTracker tracker;
  FakeSink sink, image_sink;
  TrackRun run;
};

TEST(TrackRun, GivesEveryFrameToEverySinkInOrder) {
  Trial trial(FakeSource(50));
  const TrackRunEnd end = trial.go();
  EXPECT_FALSE(end.failure);
  EXPECT_EQ(end.result.ended, "end of data");
  for (const FakeSink* sink : {&trial.sink, &trial.image_sink}) {
    ASSERT_EQ(sink->frames.size(), 50U);
    for (std::int64_t i = 0; i < 50; ++i) EXPECT_EQ(sink->frames[static_cast<std::size_t>(i)].index, i);
    EXPECT_EQ(sink->finished, 1);
    EXPECT_TRUE(sink->image_was_there);
  }
}

TEST(TrackRun, AddsUpTheCountsOfTheFrames) {
  Trial trial(FakeSource(7));  // new, followed, lost, re-identified, followed, lost, re-identified
  const TrackResult result = trial.go().result;
  EXPECT_EQ(result.frames, 7);
  EXPECT_EQ(result.features, 1);
  EXPECT_EQ(result.tracked, 2);
  EXPECT_EQ(result.reidentified, 2);
  EXPECT_EQ(result.lost, 2);
  EXPECT_EQ(result.observations, 5);
  EXPECT_DOUBLE_EQ(result.mean_track_length, 5.0);
  EXPECT_EQ(result.unhealthy_frames, 2);
  EXPECT_DOUBLE_EQ(result.coverage, 100.0);
  EXPECT_GT(result.peak_memory_mb, 0.0);
}

TEST(TrackRun, NumbersFramesAsInTheRecording) {
  Trial trial(FakeSource(6, {104}, 100, 2));  // 100 102 (104) 106 108 110
  trial.go();
  std::vector<std::int64_t> numbers, last_seen;
  for (const TrackFrame& frame : trial.sink.frames) {
    numbers.push_back(frame.index);
    last_seen.push_back(frame.features.empty() ? -2 : frame.features[0].last_seen);
  }
  EXPECT_EQ(numbers, (std::vector<std::int64_t>{100, 102, 106, 108, 110}));
  EXPECT_EQ(last_seen, (std::vector<std::int64_t>{-1, 100, -2, 102, 108}));
}

TEST(TrackRun, SkipsBrokenFramesAndReportsThem) {
  const auto path = scratch_path("skip");
  RunFolder folder(path, false);
  Trial trial(FakeSource(10, {3, 4, 9}));
  trial.run.folder = &folder;
  trial.run.frames_asked = 10;
  const TrackRunEnd end = trial.go();
  EXPECT_FALSE(end.failure);
  EXPECT_EQ(end.result.frames, 7);
  EXPECT_EQ(end.result.skipped_frames, 3);
  EXPECT_DOUBLE_EQ(end.result.coverage, 70.0);
  EXPECT_EQ(end.first_skip, "frame 3 is broken");
  EXPECT_THAT(read_whole_file(path / "events.jsonl"), testing::HasSubstr("frame 9 is broken"));
}

TEST(TrackRun, AnUnusableSourceEndsTheRunButKeepsWhatWasComputed) {
  Trial trial(FakeSource(10));
  trial.source.become_unusable_from(4);
  const TrackRunEnd end = trial.go();
  EXPECT_THROW(std::rethrow_exception(end.failure), UnusableSource);
  EXPECT_EQ(end.result.frames, 4);
  EXPECT_EQ(trial.sink.frames.size(), 4U);
  EXPECT_EQ(trial.image_sink.frames.size(), 4U) << "what waits for the writer is written";
  EXPECT_EQ(trial.image_sink.finished, 1);
}

TEST(TrackRun, StopsAfterTheCurrentFrame) {
  std::atomic<bool> stop = false;
  Trial trial(FakeSource(1000));
  trial.run.stop = &stop;
  trial.run.frames_asked = 1000;
  trial.run.progress = [&](const TrackProgress& progress) { stop = progress.done == 20; };
  const TrackRunEnd end = trial.go();
  EXPECT_TRUE(end.result.interrupted);
  EXPECT_FALSE(end.failure);
  EXPECT_EQ(trial.sink.frames.size(), 20U);
  EXPECT_EQ(trial.image_sink.frames.size(), 20U);
  EXPECT_EQ(trial.sink.finished, 1);
  EXPECT_DOUBLE_EQ(end.result.coverage, 2.0);
}

TEST(TrackRun, AFailingImageSinkIsReported) {
  Trial trial(FakeSource(100));
  trial.image_sink.fail_at = 3;
  const TrackRunEnd end = trial.go();
  EXPECT_THROW(std::rethrow_exception(end.failure), Error);
  EXPECT_LT(end.result.frames, 100) << "the run does not go on for long";
  EXPECT_EQ(trial.sink.finished, 1);
}

TEST(TrackRun, AFailingTextSinkIsReported) {
  Trial trial(FakeSource(100));
  trial.sink.fail_at = 3;
  const TrackRunEnd end = trial.go();
  EXPECT_THROW(std::rethrow_exception(end.failure), Error);
  EXPECT_EQ(end.result.ended, "the disk is full");
}

TEST(TrackRun, MasksReachTheTracker) {
  const GrayImage mask(32, 24);
  Trial trial(FakeSource(3));
  trial.run.mask_of = [&](const Frame&) { return mask.view(); };
  EXPECT_EQ(trial.go().result.masked, 3);
}

TEST(TrackRun, StatsHaveARowPerFrame) {
  const auto path = scratch_path("stats");
  RunFolder folder(path, false);
  Trial trial(FakeSource(5));
  trial.run.folder = &folder;
  trial.go();
  const std::string stats = read_whole_file(path / "stats.csv");
  EXPECT_EQ(std::count(stats.begin(), stats.end(), '\n'), 6);
  EXPECT_THAT(read_whole_file(path / "events.jsonl"), testing::HasSubstr("few"));
}

}  // namespace
}  // namespace rastro
