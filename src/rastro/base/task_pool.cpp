// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/task_pool.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"

#ifdef RASTRO_UNDER_TSAN
#include <sanitizer/tsan_interface.h>
#endif

namespace rastro {
namespace {

constexpr int most_threads = 256;

/// How many threads can be started: TBB ends the program where the memory or the number of processes does not allow one
/// that it wants. Four times as many as wanted are tried, each with an allocation, for which the allocator reserves
/// address space per thread; that leaves room for the memory that the work needs.
int startable_threads(int wanted) {
  constexpr std::size_t tried_per_thread = 4;
  static std::mutex mutex;
  static int known = 1;
  static bool limited = false;
  const std::lock_guard lock(mutex);
  if (wanted <= known || limited) return std::min(wanted, known);
  std::atomic<bool> over = false;
  std::vector<std::thread> trial;
  try {
    trial.reserve(tried_per_thread * static_cast<std::size_t>(wanted));
    const auto reserve_and_wait = [&over] {
      void* volatile reserved = std::malloc(64);
      over.wait(false);
      std::free(reserved);
    };
    while (trial.size() < trial.capacity()) trial.emplace_back(reserve_and_wait);
  } catch (const std::exception&) {
    limited = true;
  }
  over = true;
  over.notify_all();
  for (std::thread& thread : trial) thread.join();
  known = limited ? std::clamp(static_cast<int>(trial.size() / tried_per_thread), 1, wanted) : wanted;
  return known;
}

int usable_threads(int wanted) {
  if (wanted == 0) wanted = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int usable = wanted == 1 ? 1 : startable_threads(std::min(wanted, most_threads));
  static std::atomic<bool> said = false;
  if (usable < wanted && !said.exchange(true))
    log_warning(fmt::format("{} of {} threads are used: {}", usable, wanted,
                            usable == most_threads ? "more are of no use" : "the system does not allow to start more"));
  return usable;
}

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

TaskPool::TaskPool(int threads, TaskPriority priority) : threads_(usable_threads(std::max(0, threads))) {
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
