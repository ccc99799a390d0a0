// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/time.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

TEST(Time, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(from_seconds(0.1), 100'000'000);
  EXPECT_EQ(from_seconds(-1.5), -1'500'000'000);
  EXPECT_EQ(from_seconds(2e-9 + 0.6e-9), 3);
  EXPECT_DOUBLE_EQ(to_seconds(1'403'636'579'763'555'584), 1403636579.763555584);
}

}  // namespace
}  // namespace rastro
