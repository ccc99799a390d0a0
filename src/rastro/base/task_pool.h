// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

namespace rastro {

/// Who goes first where loops of several pools run at the same time.
enum class TaskPriority { low, normal };

/// Runs loops on a fixed number of threads. Work is cut into chunks that depend only on the range and grain, never on
/// the number of threads; a body that writes only to places of its own index therefore gives the same bytes for any
/// pool.
class TaskPool {
 public:
  /// `threads` >= 1; 0 takes the machine's count. One thread runs everything in the caller.
  /// Each pool starts its loops at once, whatever others are at; helpers go to the one of higher priority.
  explicit TaskPool(int threads, TaskPriority priority = TaskPriority::normal);
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  int threads() const { return threads_; }
  /// Calls body(chunk_begin, chunk_end) over [begin, end) in chunks of `grain`; returns when all are done.
  /// An exception of a body is rethrown here.
  void for_chunks(int begin, int end, int grain, const std::function<void(int, int)>& body);

 private:
  struct Arena;
  int threads_;
  std::unique_ptr<Arena> arena_;
};

}  // namespace rastro
