// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/scan_text.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <sstream>

#include "rastro/base/text.h"
#include "rastro/sensor/stamp_text.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

LaserScan scan_of(std::vector<float> ranges) {
  LaserScan scan;
  scan.first_angle = -0.5;
  scan.angle_step = 0.25;
  scan.min_range = 0.125;
  scan.max_range = 8.0;
  scan.ranges = std::move(ranges);
  return scan;
}

std::vector<std::string> words_of(const LaserScan& scan, const SE2& odometry = SE2(), TimeNs stamp = 0) {
  std::istringstream line(carmen_robot_laser_line(scan, odometry, stamp));
  std::vector<std::string> words;
  for (std::string word; line >> word;) words.push_back(word);
  return words;
}

TEST(LaserScan, TellsReturnsFromFreeAndBrokenBeams) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  const LaserScan scan = scan_of({0.125F, 0.126F, 7.99F, 8.0F, 9.0F, infinite, std::nanf(""), -1.0F, -infinite});
  const bool returned[] = {false, true, true, false, false, false, false, false, false};
  const bool free[] = {false, false, false, true, true, true, false, false, false};
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    EXPECT_EQ(scan.is_return(beam), returned[beam]) << beam;
    EXPECT_EQ(scan.is_free(beam), free[beam]) << beam;
  }
  EXPECT_DOUBLE_EQ(scan.angle_of(3), 0.25);
}

TEST(CarmenLine, HasTheGeometryAndWhatEveryBeamSays) {
  const auto words = words_of(scan_of({1.5F, std::nanf(""), 0.05F, 20.0F, 7.25F}));
  const std::vector<std::string> expected = {"ROBOTLASER1", "0",   "-0.5", "1", "0.25", "8",    "0.01", "0",
                                             "5",           "1.5", "0",    "0", "8",    "7.25", "0"};
  ASSERT_GE(words.size(), expected.size());
  EXPECT_EQ(std::vector<std::string>(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(expected.size())),
            expected);
  EXPECT_EQ(words.size(), expected.size() + 6 + 5 + 3) << "two poses, five numbers, two stamps and a host";
}

TEST(CarmenLine, APoseOfTheLaserIsThatOfTheBodyAndItsPoseThere) {
  LaserScan scan = scan_of({});
  scan.body_from_laser = SE2(SO2::from_angle(std::numbers::pi / 2.0), {0.5, 0.25});
  const auto words = words_of(scan, SE2(SO2::from_angle(std::numbers::pi / 2.0), {3.0, -4.0}), 1'500'000'000);
  const double expected[] = {2.75, -3.5, std::numbers::pi, 3.0, -4.0, std::numbers::pi / 2.0};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(std::abs(parse_double(words[10 + i]).value()), std::abs(expected[i]), 1e-12) << i;
  EXPECT_LT(parse_double(words[11]).value(), 0.0);
  EXPECT_EQ(words[3], "0") << "no beams, no field of view";
  EXPECT_EQ(words[21], "1.500000000");
  EXPECT_EQ(words[22], "rastro");
  EXPECT_EQ(words.back(), "1.500000000");
}

TEST(CarmenLine, RangesReadBackExactlyEvenBesideTheLargest) {
  for (const double largest : {8.0, 8.1, 29.99, 81.83}) {
    LaserScan scan = scan_of({});
    scan.max_range = largest;
    const auto nearest = static_cast<float>(largest);
    scan.ranges = {std::nextafter(nearest, 0.0F), nearest, std::nextafter(nearest, 100.0F), 0.1250001F};
    const auto words = words_of(scan);
    for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      LaserScan again = scan;
      again.ranges[beam] = static_cast<float>(parse_double(words[9 + beam]).value());
      EXPECT_EQ(again.is_return(beam), scan.is_return(beam)) << largest << ' ' << beam;
      EXPECT_EQ(again.is_free(beam), scan.is_free(beam)) << largest << ' ' << beam;
      if (scan.is_return(beam)) {
        EXPECT_EQ(again.ranges[beam], scan.ranges[beam]) << largest << ' ' << beam;
      }
    }
  }
}

TEST(FreeRange, IsTheSmallestFloatThatIsNoReturn) {
  for (const double largest : {8.0, 8.1, 29.99, 30.01, 81.83}) {
    const float free = free_range(largest);
    EXPECT_GE(static_cast<double>(free), largest);
    EXPECT_LT(static_cast<double>(std::nextafter(free, 0.0F)), largest);
  }
}

TEST(StampText, EveryUnitHasItsNameAndItsDecimals) {
  const std::pair<StampUnit, const char*> units[] = {{StampUnit::seconds, "s"},
                                                     {StampUnit::milliseconds, "ms"},
                                                     {StampUnit::microseconds, "us"},
                                                     {StampUnit::nanoseconds, "ns"}};
  TimeNs expected = 3 * ns_per_second;
  for (const auto& [unit, name] : units) {
    EXPECT_EQ(unit_name(unit), name);
    EXPECT_EQ(parse_stamp("3", unit), expected);
    expected /= 1000;
  }
}

TEST(StampText, RoundsHalfAwayFromZeroUpToTheLargestStamp) {
  EXPECT_EQ(parse_stamp("1.4999999999", StampUnit::nanoseconds), 1);
  EXPECT_EQ(parse_stamp("1.5", StampUnit::nanoseconds), 2);
  EXPECT_EQ(parse_stamp("-1.5", StampUnit::nanoseconds), -2);
  EXPECT_EQ(parse_stamp("+12e2", StampUnit::nanoseconds), 1200);
  EXPECT_EQ(parse_stamp("12e-1", StampUnit::nanoseconds), 1);
  EXPECT_EQ(parse_stamp("0e1000", StampUnit::nanoseconds), 0);
  EXPECT_FALSE(parse_stamp("0e1001", StampUnit::nanoseconds));
  const std::string largest = std::to_string(largest_stamp), beyond = std::to_string(largest_stamp + 1);
  EXPECT_EQ(parse_stamp(largest, StampUnit::nanoseconds), largest_stamp);
  EXPECT_EQ(parse_stamp(largest + ".4", StampUnit::nanoseconds), largest_stamp);
  EXPECT_FALSE(parse_stamp(largest + ".5", StampUnit::nanoseconds));
  EXPECT_FALSE(parse_stamp(beyond, StampUnit::nanoseconds));
}

TEST(StampText, SecondsAreWrittenWithNineDecimalsAndReadBack) {
  EXPECT_EQ(seconds_text(0), "0.000000000");
  EXPECT_EQ(seconds_text(-1), "-0.000000001");
  EXPECT_EQ(seconds_text(1'305'031'239'529'662'001), "1305031239.529662001");
  EXPECT_EQ(seconds_text(std::numeric_limits<TimeNs>::min()), "-9223372036.854775808");
  for (const TimeNs stamp : {TimeNs{1}, TimeNs{-1'000'000'001}, TimeNs{999'999'999}, TimeNs{123'456'789'012'345}})
    EXPECT_EQ(parse_stamp(seconds_text(stamp), StampUnit::seconds), stamp);
}

TEST(StampText, DatesKeepToTheirRanges) {
  constexpr TimeNs day = 86'400 * ns_per_second;
  EXPECT_EQ(parse_date_stamp("1970-01-02 00:00:00"), day);
  EXPECT_EQ(parse_date_stamp("1969-12-31 23:59:59"), -ns_per_second);
  EXPECT_EQ(parse_date_stamp("1970-01-01 01:02:03.5"), (3600 + 2 * 60 + 3) * ns_per_second + ns_per_second / 2);
  EXPECT_EQ(parse_date_stamp("1970-01-01 00:00:60.9"), 60 * ns_per_second + 900'000'000) << "a leap second";
  EXPECT_EQ(parse_date_stamp("2000-02-29 00:00:00"), 11'016 * day);
  EXPECT_TRUE(parse_date_stamp("1900-01-01 00:00:00"));
  EXPECT_TRUE(parse_date_stamp("2100-12-31 23:59:59"));
  for (const char* text : {"1899-12-31 00:00:00", "2101-01-01 00:00:00", "2000-00-01 00:00:00", "2000-13-01 00:00:00",
                           "2000-01-00 00:00:00", "2000-01-32 00:00:00", "1900-02-29 00:00:00", "2000-01-01 -1:00:00",
                           "2000-01-01 00:60:00", "2000-01-01 00:-1:00", "2000-01-01 00:00:61", "2000-01-01 00:00:-1",
                           "2000-01-01 00:00:00 x", "2000-01 00:00:00"})
    EXPECT_FALSE(parse_date_stamp(text)) << text;
}

TEST(StampText, AUnitFitsWhereItsStepIsThatOfARecording) {
  const auto guess = [](double step, StampUnit native) {
    return guess_stamp_unit(std::vector<double>{0.0, step, 2.0 * step}, native);
  };
  EXPECT_EQ(guess(20.0, StampUnit::seconds), StampUnit::seconds);
  EXPECT_EQ(guess(20.1, StampUnit::seconds), StampUnit::milliseconds);
  EXPECT_EQ(guess(0.0005, StampUnit::seconds), StampUnit::seconds);
  EXPECT_EQ(guess(5e5, StampUnit::nanoseconds), StampUnit::nanoseconds);
  EXPECT_EQ(guess(4.9e5, StampUnit::nanoseconds), StampUnit::microseconds) << "2000 a second is the most";
  EXPECT_EQ(guess(0.0, StampUnit::microseconds), StampUnit::microseconds) << "nothing to tell by";
  EXPECT_EQ(guess(1e12, StampUnit::seconds), StampUnit::seconds) << "fits none: what the format says";
  EXPECT_EQ(guess_stamp_unit({}, StampUnit::milliseconds), StampUnit::milliseconds);
  // Dates from 1980 to 2099, up to a day apart.
  EXPECT_EQ(guess_stamp_unit(std::vector<double>{3.3e8, 3.3e8 + 86'400.0}, StampUnit::nanoseconds), StampUnit::seconds);
  EXPECT_EQ(guess_stamp_unit(std::vector<double>{3.1e8, 3.1e8 + 30.0}, StampUnit::milliseconds),
            StampUnit::milliseconds);
}

}  // namespace
}  // namespace rastro
