// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/frame_recorder.h"

#include <gtest/gtest.h>

#include <future>
#include <vector>

#include "rastro/base/error.h"

namespace rastro {
namespace {

Frame frame_of(std::int64_t index) {
  Frame frame;
  frame.index = index;
  return frame;
}

TEST(FrameRecorder, WritesAllFramesInOrder) {
  std::vector<std::int64_t> written;
  FrameRecorder recorder([&](const Frame& frame) { written.push_back(frame.index); });
  for (std::int64_t k = 0; k < 20; ++k) recorder.add(frame_of(k));
  EXPECT_EQ(recorder.finish().frames, 20);
  for (std::int64_t k = 0; k < 20; ++k) EXPECT_EQ(written.at(static_cast<std::size_t>(k)), k);
}

TEST(FrameRecorder, ADiskThatIsFullEndsTheRecordingAndNothingElse) {
  FrameRecorder recorder([](const Frame& frame) {
    if (frame.index == 2) throw Error("cannot be written (No space left on device)", "2.png", "");
  });
  for (std::int64_t k = 0; k < 5; ++k) recorder.add(frame_of(k));
  const RecordingStatistics statistics = recorder.finish();
  EXPECT_EQ(statistics.frames, 2);
  EXPECT_NE(statistics.failure.find("No space left"), std::string::npos);
  recorder.add(frame_of(6));
}

TEST(FrameRecorder, NeverWaitsForASlowDisk) {
  std::promise<void> go;
  std::shared_future<void> gone = go.get_future().share();
  FrameRecorder recorder([gone](const Frame&) { gone.wait(); }, 4);
  for (std::int64_t k = 0; k < 20; ++k) recorder.add(frame_of(k));
  go.set_value();
  const RecordingStatistics statistics = recorder.finish();
  EXPECT_EQ(statistics.frames + statistics.dropped, 20);
  EXPECT_GE(statistics.dropped, 15);
}

TEST(FrameRecorder, LeavesOutWhatIsNotWrittenInTime) {
  std::promise<void> go;
  std::shared_future<void> gone = go.get_future().share();
  FrameRecorder recorder([gone](const Frame&) { gone.wait(); });
  for (std::int64_t k = 0; k < 20; ++k) recorder.add(frame_of(k));
  go.set_value();
  const RecordingStatistics statistics = recorder.finish(std::chrono::milliseconds(-1000));
  EXPECT_EQ(statistics.frames + statistics.dropped, 20) << "all are counted";
  EXPECT_EQ(recorder.finish().dropped, statistics.dropped);
}

}  // namespace
}  // namespace rastro
