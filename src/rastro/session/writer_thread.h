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

/// Hands frames to slow sinks (pictures, video) on a thread of its own, in order. The queue is bounded: write() waits
/// when it is full, so memory does not grow. An exception of a sink comes out of the next write() or of finish().
class WriterThread {
 public:
  WriterThread(std::vector<TrackSink*> sinks, std::size_t queue_length);
  /// Drops what is still queued; finish() first to keep it.
  ~WriterThread();
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  void write(TrackFrame frame, GreyImage image);
  /// Returns when everything has been written and the sinks are finished.
  void finish();

 private:
  struct Job {
    TrackFrame frame;
    GreyImage image;
  };
  void work();
  void rethrow();

  std::vector<TrackSink*> sinks_;
  const std::size_t queue_length_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> queue_;  ///< The first one is being written and leaves only then.
  std::exception_ptr failure_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace rastro
