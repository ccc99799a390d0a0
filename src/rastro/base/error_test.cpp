// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/error.h"

#include <gmock/gmock.h>

namespace rastro {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Error, SaysWhereWhatAndWhatToDo) {
  EXPECT_STREQ(Error("is empty", "data.csv", "record at least one frame").what(),
               "data.csv: is empty; record at least one frame");
  EXPECT_STREQ(Error("is empty", "data.csv", "").what(), "data.csv: is empty");
  EXPECT_STREQ(Error("one line").what(), "one line");
}

TEST(Check, HoldsItsPeaceWhenThePromiseIsKept) { EXPECT_NO_THROW(RASTRO_CHECK(1 + 1 == 2, "sums work")); }

TEST(Check, NamesPlacePromiseAndCondition) {
  try {
    RASTRO_CHECK(1 + 1 == 3, "sums are odd");
    FAIL() << "a broken promise went unnoticed";
  } catch (const Fault& fault) {
    EXPECT_THAT(fault.what(), AllOf(HasSubstr("error_test.cpp:"), HasSubstr("sums are odd"), HasSubstr("1 + 1 == 3"),
                                    Not(HasSubstr("\n"))));
  }
}

}  // namespace
}  // namespace rastro
