// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "rastro/sensor/frame.h"
#include "rastro/session/live_statistics.h"

namespace rastro {

/// Records frames beside a run in a thread of its own, which never holds up or ends the run: where writing is too slow,
/// frames are left out and counted; where it fails (disk full), recording ends with one line in the log.
class FrameRecorder {
 public:
  /// `write` is called in the recorder's thread and throws Error on failure. `queue`: frames that may wait.
  explicit FrameRecorder(std::function<void(const Frame&)> write, std::size_t queue = 32);
  /// Writes what waits.
  ~FrameRecorder();

  /// Copies the frame. Never throws for what happens to the recording.
  void add(const Frame& frame);
  /// Writes what waits, but for no longer than `at_most` beside the frame at hand: what then waits still is left out
  /// and counted. Tells how it went.
  RecordingStatistics finish(std::chrono::milliseconds at_most = std::chrono::seconds(60));

 private:
  void write_all();

  std::function<void(const Frame&)> write_;
  std::size_t most_;
  std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<Frame> queue_;
  RecordingStatistics statistics_;
  bool finishing_ = false;
  std::chrono::steady_clock::time_point until_;  ///< Once finishing.
  std::thread thread_;                           // Last: it uses all of the above.
};

}  // namespace rastro
