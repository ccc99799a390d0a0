// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace rastro {

/// One worker that runs jobs in the order in which they were given. With or without a thread of its own the jobs do the
/// same: who takes their results at a fixed place of his own work gets the same bytes either way.
class Background {
 public:
  /// `own_thread` false: a job runs in submit().
  explicit Background(bool own_thread);
  /// Waits for the jobs given so far; their exceptions are dropped.
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// Number of the job, from 1. After a job that threw no other is run.
  std::size_t submit(std::function<void()> job);
  /// Returns when the job of that number and all before it are done. An exception of one of them is thrown here, in
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
