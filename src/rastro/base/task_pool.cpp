// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/task_pool.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <thread>

#include "rastro/base/error.h"

#ifdef RASTRO_UNDER_TSAN
#include <sanitizer/tsan_interface.h>
#endif

namespace rastro {
namespace {

/// Debian's oneTBB is not compiled with ThreadSanitizer, which therefore does not see that a loop begins after
/// everything before it and ends before everything after it. Chunks are not ordered relative to each other.
class LoopOrder {
 public:
#ifdef RASTRO_UNDER_TSAN
  LoopOrder() { __tsan_release(&begin_); }
  ~LoopOrder() { __tsan_acquire(&end_); }
  void begin_chunk() { __tsan_acquire(&begin_); }
  void end_chunk() { __tsan_release(&end_); }

 private:
  char begin_ = 0, end_ = 0;
#else
  void begin_chunk() {}
  void end_chunk() {}
#endif
};

}  // namespace

struct TaskPool::Arena {
  Arena(int threads, TaskPriority priority)
      : allowed(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena(threads, 1,
              priority == TaskPriority::low ? oneapi::tbb::task_arena::priority::low
                                            : oneapi::tbb::task_arena::priority::normal) {}
  /// Without it TBB warns on standard error about more threads than the machine has.
  oneapi::tbb::global_control allowed;
  oneapi::tbb::task_arena arena;
};

TaskPool::TaskPool(int threads, TaskPriority priority)
    : threads_(threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))) {
  if (threads_ > 1) arena_ = std::make_unique<Arena>(threads_, priority);
}

TaskPool::~TaskPool() = default;

void TaskPool::for_chunks(int begin, int end, int grain, const std::function<void(int, int)>& body) {
  RASTRO_CHECK(grain > 0, "a chunk holds at least one item");
  if (begin >= end) return;
  const int chunks = (end - begin - 1) / grain + 1;
  const auto run = [&](int chunk) {
    const int chunk_begin = begin + chunk * grain;
    body(chunk_begin, std::min(end, chunk_begin + grain));
  };
  if (!arena_ || chunks == 1) {
    for (int chunk = 0; chunk < chunks; ++chunk) run(chunk);
    return;
  }
  LoopOrder order;
  const auto run_in_order = [&](int chunk) {
    order.begin_chunk();
    run(chunk);
    order.end_chunk();
  };
  arena_->arena.execute([&] { oneapi::tbb::parallel_for(0, chunks, run_in_order, oneapi::tbb::simple_partitioner()); });
}

}  // namespace rastro
