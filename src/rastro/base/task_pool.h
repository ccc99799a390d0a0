// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

namespace rastro {

/// Which pool gets the helper threads first when several pools run loops at the same time.
enum class TaskPriority { low, normal };

/// Runs loops on a fixed number of threads. The chunks depend only on the range and grain, never on the number of
/// threads. A body that writes only to the elements of its own index therefore gives the same bytes for any pool.
class TaskPool {
 public:
  /// `threads` >= 1; 0 uses the machine's count. Where the
  /// system does not allow to start as many, or above 256, fewer are used, with a warning. With one thread everything
  /// runs in the caller. Each pool starts its loops at once, whatever the others do; helper threads go to the pool with
  /// higher priority.
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
