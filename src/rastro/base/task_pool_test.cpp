// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/task_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using Chunk = std::pair<int, int>;

std::set<Chunk> chunks_of(TaskPool& pool, int begin, int end, int grain) {
  std::vector<std::atomic<int>> ends(static_cast<std::size_t>(std::max(1, end - begin)));
  pool.for_chunks(begin, end, grain, [&](int from, int to) { ends.at(static_cast<std::size_t>(from - begin)) += to; });
  std::set<Chunk> chunks;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (ends[i] != 0) chunks.emplace(begin + static_cast<int>(i), ends[i].load());
  }
  return chunks;
}

TEST(TaskPool, ChunksDependOnRangeAndGrainOnly) {
  const std::set<Chunk> expected = {{3, 7}, {7, 11}, {11, 13}};
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    EXPECT_EQ(chunks_of(pool, 3, 13, 4), expected) << threads << " threads";
  }
}

TEST(TaskPool, VisitsEveryIndexOnce) {
  TaskPool pool(8);
  std::vector<std::atomic<int>> visits(10'000);
  pool.for_chunks(0, 10'000, 7, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) ++visits.at(static_cast<std::size_t>(i));
  });
  for (const auto& count : visits) ASSERT_EQ(count, 1);
}

TEST(TaskPool, AnEmptyRangeCallsNothing) {
  TaskPool pool(2);
  const auto never = [](int, int) { FAIL(); };
  pool.for_chunks(5, 5, 1, never);
  pool.for_chunks(5, 4, 1, never);
}

TEST(TaskPool, RethrowsAndCanBeUsedAgain) {
  for (const int threads : {1, 2, 8}) {
    TaskPool pool(threads);
    const auto fail_once = [](int begin, int) {
      if (begin == 50) throw std::runtime_error("chunk 50");
    };
    EXPECT_THROW(pool.for_chunks(0, 100, 10, fail_once), std::runtime_error);
    EXPECT_EQ(chunks_of(pool, 0, 2, 1).size(), 2U);
  }
}

TEST(TaskPool, LoopsMayBeNested) {
  TaskPool pool(4);
  std::atomic<int> calls = 0;
  pool.for_chunks(0, 8, 1, [&](int, int) { pool.for_chunks(0, 8, 1, [&](int, int) { ++calls; }); });
  EXPECT_EQ(calls, 64);
}

TEST(TaskPool, ZeroThreadsUsesTheMachinesCount) { EXPECT_GE(TaskPool(0).threads(), 1); }

TEST(TaskPool, AGrainOfZeroIsAFault) {
  TaskPool pool(1);
  EXPECT_THROW(pool.for_chunks(0, 1, 0, [](int, int) {}), Fault);
}

TEST(TaskPool, UsesNoMoreThreadsThanAreOfUse) {
  TaskPool pool(100'000);
  EXPECT_GE(pool.threads(), 1);
  EXPECT_LE(pool.threads(), 256);
  EXPECT_EQ(chunks_of(pool, 0, 10, 4), (std::set<Chunk>{{0, 4}, {4, 8}, {8, 10}}));
}

}  // namespace
}  // namespace rastro
