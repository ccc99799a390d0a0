// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace rastro {

/// One worker that runs jobs in the order of submission. With or without a thread of its own the jobs do the same: a
/// caller that takes their results at a fixed point of its own work gets the same bytes either way.
class Background {
 public:
  /// `own_thread` false: a job runs in submit().
  explicit Background(bool own_thread);
  /// Waits for the submitted jobs; drops their exceptions.
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// Returns the number of the job, from 1. After a job that threw, no other job runs.
  std::size_t submit(std::function<void()> job);
  /// Waits until the job of that number and all before it are done. An exception of one of them is thrown here, in
  /// either mode, and again at each later call.
  void wait(std::size_t job);
  void wait_for_all();
  /// Whether wait() would return at once.
  bool is_done(std::size_t job) const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
