// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/background.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace rastro {

class Background::State {
 public:
  explicit State(bool own_thread) {
    try {
      if (own_thread) thread_ = std::thread([this] { work(); });
    } catch (const std::system_error&) {
      // The system allows no more threads: the jobs run in submit().
    }
  }

  ~State() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  std::size_t submit(std::function<void()> job) {
    if (!thread_.joinable()) {
      run(job);
      return ++submitted_;
    }
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(std::move(job));
      ++submitted_;
    }
    changed_.notify_all();
    return submitted_;
  }

  void wait(std::size_t job) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return done_ >= job; });
    if (failure_ && failed_job_ <= job) std::rethrow_exception(failure_);
  }

  bool is_done(std::size_t job) {
    const std::lock_guard lock(mutex_);
    return done_ >= job;
  }

  std::size_t submitted() const { return submitted_; }

 private:
  void work() {
    while (true) {
      std::function<void()> job;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return ending_ || !jobs_.empty(); });
        if (jobs_.empty()) return;
        job = std::move(jobs_.front());
        jobs_.pop_front();
      }
      run(job);
      changed_.notify_all();
    }
  }

  /// Releases what the job holds before it counts as done.
  void run(std::function<void()>& job) {
    std::exception_ptr failure;
    try {
      if (!failure_) job();
    } catch (...) {
      failure = std::current_exception();
    }
    job = nullptr;
    const std::lock_guard lock(mutex_);
    ++done_;
    if (failure) {
      failure_ = failure;
      failed_job_ = done_;
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;
  std::size_t submitted_ = 0;  ///< Accessed by the caller's thread only.
  std::size_t done_ = 0, failed_job_ = 0;
  std::exception_ptr failure_;  ///< Written by the worker only.
  bool ending_ = false;
  std::thread thread_;
};

Background::Background(bool own_thread) : state_(std::make_unique<State>(own_thread)) {}
Background::~Background() = default;
std::size_t Background::submit(std::function<void()> job) { return state_->submit(std::move(job)); }
void Background::wait(std::size_t job) { state_->wait(job); }
bool Background::is_done(std::size_t job) const { return state_->is_done(job); }
void Background::wait_for_all() { state_->wait(state_->submitted()); }

}  // namespace rastro
