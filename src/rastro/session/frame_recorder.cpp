// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/frame_recorder.h"

#include <exception>
#include <new>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/log.h"

namespace rastro {

FrameRecorder::FrameRecorder(std::function<void(const Frame&)> write, std::size_t queue)
    : write_(std::move(write)), most_(queue), thread_([this] { write_all(); }) {}

FrameRecorder::~FrameRecorder() { finish(); }

void FrameRecorder::add(const Frame& frame) {
  const std::lock_guard lock(mutex_);
  if (finishing_ || !statistics_.failure.empty()) return;
  if (queue_.size() >= most_) {
    ++statistics_.dropped;
    return;
  }
  try {
    queue_.push_back(frame);
  } catch (const std::bad_alloc&) {
    ++statistics_.dropped;  // the run goes on
  }
  filled_.notify_one();
}

RecordingStatistics FrameRecorder::finish(std::chrono::milliseconds at_most) {
  {
    const std::lock_guard lock(mutex_);
    if (!finishing_) until_ = std::chrono::steady_clock::now() + at_most;
    finishing_ = true;
    filled_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
  return statistics_;
}

void FrameRecorder::write_all() {
  std::unique_lock lock(mutex_);
  for (;;) {
    filled_.wait(lock, [this] { return !queue_.empty() || finishing_; });
    if (queue_.empty()) return;
    if (finishing_ && std::chrono::steady_clock::now() > until_) {
      statistics_.dropped += static_cast<std::int64_t>(queue_.size());
      return;
    }
    const Frame frame = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    std::string failure;
    try {
      write_(frame);
    } catch (const std::exception& error) {
      failure = error.what();
      log_warning("recording ends, the run goes on: " + failure);
    }
    lock.lock();
    if (failure.empty()) {
      ++statistics_.frames;
      continue;
    }
    statistics_.failure = failure;
    queue_.clear();
    return;
  }
}

}  // namespace rastro
