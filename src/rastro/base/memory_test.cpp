// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/memory.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "rastro/base/sanitizer_testing.h"

namespace rastro {
namespace {

TEST(Memory, GrowsWithTouchedPagesAndThePeakStays) {
  const double before = resident_memory_mb();
  ASSERT_GT(before, 0.0);
  double held = 0.0;
  {
    std::vector<char> block(64 << 20, 1);
    held = resident_memory_mb();
    EXPECT_EQ(block.at(block.size() / 2), 1);
  }
  EXPECT_GT(held, before + 60.0);
  // The kernel updates the two counts at slightly different moments.
  EXPECT_GT(peak_resident_memory_mb(), held - 1.0);
}

/// The last block pins what is below it.
TEST(Memory, WhatWasFreedIsResidentUntilItIsReturned) {
  if (sanitizes_memory) GTEST_SKIP() << "the allocator is another one";
  std::vector<std::unique_ptr<std::array<char, 1000>>> blocks(60000);
  for (auto& block : blocks) {
    block = std::make_unique<std::array<char, 1000>>();
    block->fill('x');
  }
  for (std::size_t k = 0; k + 1 < blocks.size(); ++k) blocks[k].reset();
  const double before = resident_memory_mb();
  return_freed_memory();
  EXPECT_LT(resident_memory_mb(), before - 40.0);
}

}  // namespace
}  // namespace rastro
