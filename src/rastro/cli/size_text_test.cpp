// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/size_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/error.h"

namespace rastro::cli {
namespace {

std::string refusal(const std::string& text) {
  try {
    return std::to_string(parse_size(text, "--max-memory"));
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(SizeText, ReadsWhatPeopleWrite) {
  EXPECT_EQ(parse_size("600MB", "f"), 600'000'000U);
  EXPECT_EQ(parse_size("1.5 GiB", "f"), 1'610'612'736U);
  EXPECT_EQ(parse_size("4096", "f"), 4096U);
  EXPECT_EQ(parse_size("2kB", "f"), 2000U);
}

TEST(SizeText, SaysWhatWasMeant) {
  EXPECT_THAT(refusal("600mb"), testing::HasSubstr("did you mean 600MB?"));
  EXPECT_THAT(refusal("1e99GB"), testing::HasSubstr("has an unknown unit"));
  EXPECT_THAT(refusal("2G"), testing::HasSubstr("did you mean 2GB?"));
  EXPECT_THAT(refusal("512 MiBs"), testing::HasSubstr("did you mean 512MiB?"));
  for (const char* text : {"", "MB", "-3MB", "0", "nan", "6 00MB", "9999999999GB"})
    EXPECT_THAT(refusal(text), testing::AllOf(testing::HasSubstr("--max-memory"), testing::HasSubstr("600MB"))) << text;
}

}  // namespace
}  // namespace rastro::cli
