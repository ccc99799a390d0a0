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

TEST(Check, ATrueConditionIsEvaluatedOnceAndItsMessageNever) {
  int asked = 0, made = 0;
  const auto message = [&made] { return std::to_string(++made); };
  // Without braces: it must be one statement.
  if (made == 0)
    RASTRO_CHECK(++asked == 1, message());
  else
    FAIL() << "the else belongs to the if";
  EXPECT_EQ(asked, 1) << "on in releases, and without doing the work of its condition twice";
  EXPECT_EQ(made, 0);
}

TEST(Check, NamesLocationMessageAndCondition) {
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
