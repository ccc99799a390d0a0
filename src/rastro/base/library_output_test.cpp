// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/library_output.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <thread>

namespace rastro {
namespace {

TEST(LibraryOutput, CollectsWhatItsOwnThreadPrints) {
#ifndef __GLIBC__
  GTEST_SKIP() << "only glibc's stderr can be diverted";
#endif
  divert_library_output();
  const LibraryOutput outer;
  std::fprintf(stderr, "libpng warning: %d\n", 1);
  {
    const LibraryOutput inner;
    std::fputs("inner", stderr);
    EXPECT_EQ(inner.text(), "inner");
  }
  std::thread([] {
    const LibraryOutput other;
    std::fputs("other", stderr);
    EXPECT_EQ(other.text(), "other");
  }).join();
  EXPECT_EQ(outer.text(), "libpng warning: 1\n");
}

}  // namespace
}  // namespace rastro
