// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/writer_thread.h"

#include <system_error>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {

WriterThread::WriterThread(std::vector<TrackSink*> sinks, std::size_t queue_length)
    : sinks_(std::move(sinks)), queue_length_(queue_length) {
  RASTRO_CHECK(queue_length > 0, "a queue holds at least one frame");
  try {
    if (!sinks_.empty()) thread_ = std::thread([this] { work(); });
  } catch (const std::system_error&) {
    // The system allows no more threads: write() does the work.
  }
}

WriterThread::~WriterThread() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void WriterThread::write(TrackFrame frame, GrayImage image) {
  if (!thread_.joinable()) {
    for (TrackSink* sink : sinks_) sink->write(frame, image);
    return;
  }
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return queue_.size() < queue_length_ || failure_; });
  rethrow();
  queue_.push_back({std::move(frame), std::move(image)});
  changed_.notify_all();
}

void WriterThread::finish() {
  if (sinks_.empty()) return;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return queue_.empty() || failure_; });
  rethrow();
  for (TrackSink* sink : sinks_) sink->finish();
}

void WriterThread::rethrow() {
  if (failure_) std::rethrow_exception(failure_);
}

void WriterThread::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return !queue_.empty() || stopping_; });
    if (stopping_ || failure_) return;
    const Job& job = queue_.front();  // a deque does not move it when others are appended
    lock.unlock();
    std::exception_ptr failure;
    try {
      for (TrackSink* sink : sinks_) sink->write(job.frame, job.image);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    queue_.pop_front();
    failure_ = failure;
    changed_.notify_all();
    if (failure_) return;
  }
}

}  // namespace rastro
