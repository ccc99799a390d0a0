// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/text.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace rastro {
namespace {

using testing::ElementsAre;

TEST(ParseNumber, UsesTheWholeText) {
  EXPECT_EQ(parse_double(" -1.5e3\t"), -1500.0);
  EXPECT_EQ(parse_double("+2"), 2.0);
  EXPECT_EQ(parse_int64("-9223372036854775808"), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(parse_uint64("18446744073709551615"), std::numeric_limits<std::uint64_t>::max());
}

TEST(ParseNumber, RefusesAnythingElse) {
  for (const char* text : {"", " ", "1x", "x1", "1 2", "1,5", "++1", "+-1", "-", ".", "1e", "0x10"}) {
    EXPECT_FALSE(parse_double(text) && parse_int64(text)) << text;
    EXPECT_FALSE(parse_int64(text)) << text;
    EXPECT_FALSE(parse_uint64(text)) << text;
  }
  EXPECT_FALSE(parse_int64("9223372036854775808"));
  EXPECT_FALSE(parse_uint64("18446744073709551616"));
  EXPECT_FALSE(parse_uint64("-1"));
  EXPECT_FALSE(parse_int64("1.0"));
  EXPECT_FALSE(parse_double("1e999"));
}

TEST(ParseNumber, FiniteRefusesNanAndInfinity) {
  EXPECT_TRUE(std::isnan(parse_double("nan").value()));
  EXPECT_TRUE(std::isinf(parse_double("-inf").value()));
  EXPECT_FALSE(parse_finite("nan"));
  EXPECT_FALSE(parse_finite("-inf"));
  EXPECT_EQ(parse_finite("1e308"), 1e308);
}

TEST(Split, KeepsEmptyPieces) {
  EXPECT_THAT(split("a, b ,,c", ','), ElementsAre("a", "b", "", "c"));
  EXPECT_THAT(split("", ','), ElementsAre(""));
  EXPECT_THAT(split(",", ','), ElementsAre("", ""));
}

TEST(SplitWords, DropsRunsOfBlanks) {
  EXPECT_THAT(split_words("  a \t bc\r\n"), ElementsAre("a", "bc"));
  EXPECT_THAT(split_words(" \t"), ElementsAre());
}

TEST(Trim, TakesBlanksFromBothEnds) {
  EXPECT_EQ(trim("\t a b \r\n"), "a b");
  EXPECT_EQ(trim(" \n "), "");
}

TEST(InQuotes, StaysOneShortLine) {
  EXPECT_EQ(in_quotes("a b"), "'a b'");
  EXPECT_EQ(in_quotes(std::string("a\nb\0", 4)), "'a\\x0ab\\x00'");
  EXPECT_EQ(in_quotes(std::string(61, 'x')), "'" + std::string(60, 'x') + "...'");
}

TEST(InQuotes, IsValidUtf8WhateverComesIn) {
  EXPECT_EQ(in_quotes("Grüße €"), "'Grüße €'");
  EXPECT_EQ(in_quotes("a\xff\xc3"), "'a\\xff\\xc3'");
  // A character is never split.
  EXPECT_EQ(in_quotes(std::string(59, 'x') + "üü"), "'" + std::string(59, 'x') + "ü...'");
}

TEST(Utf8Length, KnowsWholeCharacters) {
  EXPECT_EQ(utf8_length("a"), 1U);
  EXPECT_EQ(utf8_length("ü"), 2U);
  EXPECT_EQ(utf8_length("€"), 3U);
  EXPECT_EQ(utf8_length("😀"), 4U);
  for (const char* text :
       {"", "\x80", "\xff", "\xc3", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82"}) {
    EXPECT_EQ(utf8_length(text), 0U);
  }
}

TEST(NearestName, FindsTheFewestEdits) {
  const std::vector<std::string> names = {"window", "features", "mode"};
  EXPECT_EQ(nearest_name("widnow", names), "window");
  EXPECT_EQ(nearest_name("feature", names), "features");
  EXPECT_EQ(nearest_name("mod", names), "mode");
  EXPECT_EQ(nearest_name("x", {}), "");
}

TEST(NearestName, IsNoneWhereAllAreFar) {
  const std::vector<std::string> names = {"comment", "resolution", "T_BS"};
  EXPECT_EQ(nearest_name("intrinsics", names), "");
}

TEST(DidYouMean, NamesTheNearestOrListsAll) {
  const std::vector<std::string> names = {"window", "features", "mode"};
  EXPECT_EQ(did_you_mean("widnow", names), "did you mean 'window'?");
  EXPECT_EQ(did_you_mean("intrinsics", names), "there are window, features, mode");
  EXPECT_EQ(did_you_mean("intrinsics", names, "see the list"), "see the list");
  EXPECT_EQ(did_you_mean("x", {}), "");
}

TEST(NearestName, PrefersTheEarlierOfEquals) {
  const std::vector<std::string> names = {"ab", "ac"};
  EXPECT_EQ(nearest_name("a", names), "ab");
}

TEST(ShellWord, IsQuotedOnlyWhereAShellWouldReadItOtherwise) {
  EXPECT_EQ(as_shell_word("/data/room_1"), "/data/room_1");
  EXPECT_EQ(as_shell_word("/my data/room"), "'/my data/room'");
  EXPECT_EQ(as_shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(as_shell_word("$HOME"), "'$HOME'");
  EXPECT_EQ(as_shell_word(""), "''");
}

}  // namespace
}  // namespace rastro
