// SPDX-License-Identifier: Apache-2.0
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

/// What one call of the inner next() gave: a frame, an exception, or the end.
struct Outcome {
  std::optional<Frame> frame;
  std::exception_ptr error;
};

class ReadAheadSource final : public Source {
 public:
  ReadAheadSource(std::unique_ptr<Source> source, int depth)
      : source_(std::move(source)), depth_(static_cast<std::size_t>(depth)) {
    try {
      thread_ = std::thread([this] { produce(); });
    } catch (const std::system_error&) {
      // The system allows no more threads: next() reads.
    }
  }

  ~ReadAheadSource() override {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    room_.notify_one();
    if (thread_.joinable()) thread_.join();
  }

  const SourceInfo& info() const override { return source_->info(); }

  std::optional<Frame> next() override {
    if (!thread_.joinable()) return source_->next();
    std::unique_lock lock(mutex_);
    filled_.wait(lock, [this] { return !queue_.empty() || ended_; });
    if (queue_.empty()) return std::nullopt;
    Outcome outcome = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    room_.notify_one();
    if (outcome.error) std::rethrow_exception(outcome.error);
    return std::move(outcome.frame);
  }

 private:
  void produce() {
    for (;;) {
      {
        std::unique_lock lock(mutex_);
        // Room is waited for before decoding, so that never more than depth_ frames exist here.
        room_.wait(lock, [this] { return queue_.size() < depth_ || stopping_; });
        if (stopping_) return;
      }
      Outcome outcome = read_one();
      const std::lock_guard lock(mutex_);
      if (!outcome.frame && !outcome.error) {
        ended_ = true;
        filled_.notify_one();
        return;
      }
      queue_.push_back(std::move(outcome));
      filled_.notify_one();
    }
  }

  Outcome read_one() {
    try {
      return {source_->next(), nullptr};
    } catch (...) {
      return {std::nullopt, std::current_exception()};
    }
  }

  std::unique_ptr<Source> source_;
  const std::size_t depth_;
  std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable room_;
  std::deque<Outcome> queue_;
  bool ended_ = false;
  bool stopping_ = false;
  std::thread thread_;  // Last: it uses all of the above.
};

}  // namespace

std::unique_ptr<Source> read_ahead(std::unique_ptr<Source> source, int depth) {
  RASTRO_CHECK(source != nullptr, "read_ahead needs a source");
  if (depth <= 0) return source;
  return std::make_unique<ReadAheadSource>(std::move(source), depth);
}

}  // namespace rastro
