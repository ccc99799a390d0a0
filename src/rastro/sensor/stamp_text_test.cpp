// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/stamp_text.h"

#include <gtest/gtest.h>

namespace rastro {
namespace {

TEST(StampText, DecimalsAreExactToTheNanosecond) {
  EXPECT_EQ(parse_stamp("1305031239.529662", StampUnit::seconds), 1305031239529662000);
  EXPECT_EQ(parse_stamp("1.403715529112143517e+09", StampUnit::seconds), 1403715529112143517);
  EXPECT_EQ(parse_stamp("1.037359e-01", StampUnit::seconds), 103735900);
  EXPECT_EQ(parse_stamp("1403715285262142976", StampUnit::nanoseconds), 1403715285262142976);
  EXPECT_EQ(parse_stamp("1305031239529.662", StampUnit::milliseconds), 1305031239529662000);
  EXPECT_EQ(parse_stamp(" -0.5 ", StampUnit::seconds), -500000000);
  EXPECT_EQ(parse_stamp("0.00000000049", StampUnit::seconds), 0);
  EXPECT_EQ(parse_stamp("0.0000000005", StampUnit::seconds), 1);
  EXPECT_EQ(parse_stamp("1e-900", StampUnit::seconds), 0);
}

TEST(StampText, RefusesInvalidStamps) {
  for (const char* text : {"", ".", "nan", "inf", "1.2.3", "0x10", "1e", "1e99999999999", "1 2", "--1", "9e18", "1e30",
                           "-9223372036854775808e0", "1e-9223372036854775808"}) {
    const auto stamp = parse_stamp(text, StampUnit::seconds);
    EXPECT_FALSE(stamp) << text;
  }
}

TEST(StampText, DatesAreUtc) {
  // date -u -d '2011-09-26 13:02:25' +%s
  EXPECT_EQ(parse_date_stamp("2011-09-26 13:02:25.964389445"), 1317042145964389445);
  EXPECT_EQ(parse_date_stamp("1970-01-01 00:00:00"), 0);
  for (const char* text :
       {"2011-09-26", "2011-02-30 00:00:00", "2011-09-26 24:00:00", "2011-09-26 13:02", "x-09-26 13:02:25", ""}) {
    EXPECT_FALSE(parse_date_stamp(text)) << text;
  }
}

TEST(StampText, DetectsTheUnitFromDateAndStep) {
  const std::vector<double> seconds = {1.4e9, 1.4e9 + 0.05, 1.4e9 + 0.1};
  const std::vector<double> milliseconds = {1.4e12, 1.4e12 + 50, 1.4e12 + 100};
  const std::vector<double> nanoseconds = {1.4e18, 1.4e18 + 5e7, 1.4e18 + 1e8};
  for (const auto native : {StampUnit::seconds, StampUnit::nanoseconds}) {
    EXPECT_EQ(guess_stamp_unit(seconds, native), StampUnit::seconds);
    EXPECT_EQ(guess_stamp_unit(milliseconds, native), StampUnit::milliseconds);
    EXPECT_EQ(guess_stamp_unit(nanoseconds, native), StampUnit::nanoseconds);
  }
  // Counted from zero, only the step can decide; the format's unit is kept where plausible.
  EXPECT_EQ(guess_stamp_unit(std::vector<double>{0, 33, 67}, StampUnit::seconds), StampUnit::milliseconds);
  EXPECT_EQ(guess_stamp_unit(std::vector<double>{1e9, 1.05e9, 1.1e9}, StampUnit::nanoseconds), StampUnit::nanoseconds);
  EXPECT_EQ(guess_stamp_unit(std::vector<double>{0, 10, 20}, StampUnit::seconds), StampUnit::seconds);
  EXPECT_EQ(guess_stamp_unit(std::vector<double>{5}, StampUnit::nanoseconds), StampUnit::nanoseconds);
}

}  // namespace
}  // namespace rastro
