// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/task_pool.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <thread>

#include "rastro/base/error.h"

namespace rastro {

struct TaskPool::Arena {
  Arena(int threads, TaskPriority priority)
      : allowed(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena(threads, 1,
              priority == TaskPriority::low ? oneapi::tbb::task_arena::priority::low
                                            : oneapi::tbb::task_arena::priority::normal) {}
  /// Without it TBB complains on standard error of more threads than the machine has.
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
  arena_->arena.execute([&] { oneapi::tbb::parallel_for(0, chunks, run, oneapi::tbb::simple_partitioner()); });
}

}  // namespace rastro
