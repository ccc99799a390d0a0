// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/memory.h"

#include <gtest/gtest.h>

#include <vector>

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

}  // namespace
}  // namespace rastro
