// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "rastro/image/image.h"
#include "rastro/track/track_sink.h"

namespace rastro {

/// Passes frames to slow sinks (images, video) in a thread of its own, in order. The queue is bounded: write() waits
/// while it is full, so memory does not grow. An exception of a sink is thrown by the next write() or by finish().
class WriterThread {
 public:
  WriterThread(std::vector<TrackSink*> sinks, std::size_t queue_length);
  /// Drops what is still queued; call finish() first to write it.
  ~WriterThread();
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  void write(TrackFrame frame, GrayImage image);
  /// Returns when everything has been written and the sinks are finished.
  void finish();

 private:
  struct Job {
    TrackFrame frame;
    GrayImage image;
  };
  void work();
  void rethrow();

  std::vector<TrackSink*> sinks_;
  const std::size_t queue_length_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> queue_;  ///< The front job is being written and is removed only afterwards.
  std::exception_ptr failure_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace rastro
