// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "rastro/dataset/check.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"
#include "rastro/sensor/scan_text.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double pi = std::numbers::pi;

std::vector<Frame> read_all(Source& source, std::vector<std::string>* errors = nullptr) {
  std::vector<Frame> frames;
  for (;;) {
    try {
      auto frame = source.next();
      if (!frame) return frames;
      frames.push_back(std::move(*frame));
    } catch (const Error& error) {
      if (!errors) throw;
      errors->push_back(error.what());
    }
  }
}

std::string flaser(const std::vector<std::string>& ranges, const std::string& odometry, const std::string& stamp) {
  std::string line = "FLASER " + std::to_string(ranges.size());
  for (const auto& range : ranges) line += " " + range;
  return line + " 9 9 9 " + odometry + " " + stamp + " host 0.1\n";
}

const char* carmen_front = "# a comment\nPARAM robot_frontlaser_offset 0.25 nohost 0\nODOM 0 0 0 0 0 0 1.0 h 0\n";

std::string small_log() {
  return carmen_front + flaser({"1.5", "2.5", "81.83", "81.83"}, "1 2 0.5", "976052857.337530") +
         flaser({"1.5", "nan", "3.5", "81.83"}, "1.5 2 0.5", "976052857.537530");
}

TEST(CarmenLog, FlaserHasStampsOdometryAndGeometry) {
  const ScratchFolder folder;
  folder.write("a.log", small_log());
  const auto source = open(folder.path("a.log"));
  const auto& info = source->info();
  EXPECT_EQ(info.format, "carmen");
  EXPECT_EQ(info.frame_count, 2);
  EXPECT_TRUE(info.has_scan && info.has_odometry && !info.has_image);
  EXPECT_THAT(info.warnings, IsEmpty());
  const auto frames = read_all(*source);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].stamp, 976'052'857'337'530'000);
  EXPECT_EQ(frames[1].index, 1);
  EXPECT_EQ(frames[0].odometry_from_body->translation(), Eigen::Vector2d(1.0, 2.0));
  EXPECT_NEAR(frames[0].odometry_from_body->rotation().angle(), 0.5, 1e-15);
  const LaserScan& scan = *frames[0].scan;
  EXPECT_EQ(scan.first_angle, -pi / 2.0);
  EXPECT_EQ(scan.angle_step, pi / 4.0);  // Four beams: whole parts of 180 degrees.
  EXPECT_EQ(scan.body_from_laser.translation(), Eigen::Vector2d(0.25, 0.0));
  EXPECT_THAT(scan.ranges, ElementsAre(1.5F, 2.5F, 81.83F, 81.83F));
  // 81.83 repeats, so it stands for nothing.
  EXPECT_TRUE(scan.is_return(1) && !scan.is_return(2) && scan.is_free(2));
  EXPECT_FALSE(frames[1].scan->is_return(1) || frames[1].scan->is_free(1));
}

TEST(CarmenLog, AnOddNumberOfBeamsReachesFromEndToEnd) {
  const ScratchFolder folder;
  folder.write("a.log", flaser({"1", "2", "3", "4", "5"}, "0 0 0", "1"));
  const auto frames = read_all(*open(folder.path("a.log")));
  EXPECT_NEAR(frames.front().scan->angle_of(4), pi / 2.0, 1e-15);
}

TEST(CarmenLog, WithoutANumberForNothingTheParameterOrTheScannersOwnReachCounts) {
  const ScratchFolder folder;
  // One beam of more than a thousand has the largest range: a measurement like any other.
  std::vector<std::string> ranges(1500, "1.0");
  ranges[7] = "30";
  folder.write("a.log", flaser(ranges, "0 0 0", "1"));
  folder.write("b.log", "PARAM robot_front_laser_max 50.5 h 0\n" + flaser(ranges, "0 0 0", "1"));
  EXPECT_EQ(read_all(*open(folder.path("a.log"))).front().scan->max_range, 81.83);
  EXPECT_EQ(read_all(*open(folder.path("b.log"))).front().scan->max_range, 50.5);
}

LaserScan odd_scan() {
  LaserScan scan;
  scan.first_angle = -2.1000000000000001;
  scan.angle_step = 0.1 / 3.0;
  scan.max_range = 5.6;  // The nearest float is below it.
  scan.min_range = 0.3;
  const float infinity = std::numeric_limits<float>::infinity();
  scan.ranges = {1.2345678F, 0.1F, std::nanf(""), infinity, 5.6F, 5.5999994F, -1.0F, 100.0F, 3.0F};
  scan.body_from_laser = SE2(SO2::from_angle(0.3), {0.1, -0.2});
  return scan;
}

TEST(CarmenLog, AWrittenScanReadsBackExactly) {
  const ScratchFolder folder;
  const LaserScan scan = odd_scan();
  const SE2 odometry(SO2::from_angle(1.0 / 3.0), {1e3 / 7.0, -2e-9});
  const TimeNs stamp = 1'403'715'285'262'142'976;
  folder.write("a.log", carmen_header() + carmen_robot_laser_line(scan, SE2(), stamp - 1) +
                            carmen_robot_laser_line(scan, odometry, stamp));
  const auto frames = read_all(*open(folder.path("a.log")));
  ASSERT_EQ(frames.size(), 2u);
  const LaserScan& read = *frames[1].scan;
  EXPECT_EQ(frames[1].stamp, stamp);
  EXPECT_EQ(read.first_angle, scan.first_angle);
  EXPECT_EQ(read.angle_step, scan.angle_step);
  EXPECT_EQ(read.max_range, scan.max_range);
  ASSERT_EQ(read.ranges.size(), scan.ranges.size());
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    EXPECT_EQ(read.is_return(beam), scan.is_return(beam)) << beam;
    EXPECT_EQ(read.is_free(beam), scan.is_free(beam)) << beam;
    if (scan.is_return(beam)) {
      EXPECT_EQ(read.ranges[beam], scan.ranges[beam]) << beam;
    }
  }
  EXPECT_EQ(frames[1].odometry_from_body->translation(), odometry.translation());
  EXPECT_NEAR((frames[1].odometry_from_body->inverse() * odometry).log().norm(), 0.0, 1e-15);
  EXPECT_NEAR((read.body_from_laser.inverse() * scan.body_from_laser).log().norm(), 0.0, 1e-12);
}

TEST(CarmenLog, ABrokenLineKeepsItsNumberAndCostsOnlyItself) {
  const ScratchFolder folder;
  folder.write("a.log", flaser({"1", "2"}, "0 0 0", "1") + "FLASER 3 1.0 x 2.0 0 0 0 0 0 0 2 h 0\nFLASER 9 1 2\n" +
                            "FLASER 2 1 2 0 0 0 0 0 0 1 h 0 77\nFLASER 99999999999 1\n" +
                            flaser({"1", "3"}, "1 0 0", "2"));
  const auto source = open(folder.path("a.log"));
  EXPECT_EQ(source->info().frame_count, 6);
  EXPECT_THAT(source->info().warnings, ElementsAre(HasSubstr("4 of 6 frames cannot be read; the first: ")));
  std::vector<std::string> errors;
  const auto frames = read_all(*source, &errors);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].index, 5);
  EXPECT_EQ(frames[1].stamp, 2'000'000'000);
  ASSERT_EQ(errors.size(), 4u);
  EXPECT_THAT(errors[0], HasSubstr("a.log:2: "));
  EXPECT_THAT(errors[0], HasSubstr("a range is 'x'"));
  EXPECT_THAT(errors[1], HasSubstr("it ends before a range"));
  EXPECT_THAT(errors[2], HasSubstr("more numbers than its count of ranges allows"));
  EXPECT_THAT(errors[3], HasSubstr("not 0 to 100000"));
}

TEST(CarmenLog, AByteOrderMarkAndControlCharactersCostOnlyTheirLine) {
  const ScratchFolder folder;
  std::string log = "\xEF\xBB\xBF";
  for (int k = 0; k < 40; ++k) {
    std::string line = flaser({"1", "2"}, "0 0 0", std::to_string(k));
    if (k == 7 || k == 9) line[9] = '\x01';
    log += line;
  }
  folder.write("a.log", log);
  const auto source = open(folder.path("a.log"));
  EXPECT_EQ(source->info().frame_count, 38);
  EXPECT_THAT(source->info().warnings,
              Contains(HasSubstr(
                  "2 damaged lines with control characters are skipped; the first: " + folder.path("a.log") + ":8")));
  EXPECT_EQ(read_all(*source).size(), 38U);
  folder.write("b.log", std::string(1000, '\x01') + log);
  EXPECT_THAT(error_of([&] { open(folder.path("b.log")); }), HasSubstr("is neither an image nor a video"));
}

TEST(CarmenLog, FramesAreChosenByNumber) {
  const ScratchFolder folder;
  std::string text;
  for (int k = 0; k < 10; ++k) text += flaser({"1", "2"}, std::to_string(k) + " 0 0", std::to_string(k));
  folder.write("a.log", text);
  OpenOptions options;
  options.first_frame = 2;
  options.end_frame = 9;
  options.every = 3;
  std::vector<std::int64_t> numbers;
  for (const auto& frame : read_all(*open(folder.path("a.log"), options))) {
    numbers.push_back(frame.index);
    EXPECT_EQ(frame.stamp, frame.index * ns_per_second);
  }
  EXPECT_THAT(numbers, ElementsAre(2, 5, 8));
  options.first_frame = 20;
  options.end_frame = 30;
  EXPECT_THAT(error_of([&] { open(folder.path("a.log"), options); }), HasSubstr("frame 20 does not exist"));
}

TEST(CarmenLog, SaysWhatItLeavesOut) {
  const ScratchFolder folder;
  folder.write("a.log", flaser({"1", "2"}, "0 0 0", "1") + "RLASER 1 1 0 0 0 0 0 0 1 h 0\n");
  const auto source = open(folder.path("a.log"));
  EXPECT_EQ(source->info().frame_count, 1);
  EXPECT_FALSE(source->info().has_odometry);
  EXPECT_FALSE(source->next()->odometry_from_body.has_value());
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("1 scans of another kind than FLASER")));
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("is ignored")));
}

TEST(CarmenLog, WithoutAScanItIsAnError) {
  const ScratchFolder folder;
  folder.write("a.log", carmen_front);
  folder.write("b.log", "FLASER 2 1\nFLASER x\n");
  EXPECT_THAT(error_of([&] { open(folder.path("a.log")); }), HasSubstr("has no laser scans"));
  EXPECT_THAT(error_of([&] { open(folder.path("b.log")); }), HasSubstr("none of its 2 scans can be read"));
  OpenOptions options;
  options.camera = "left";
  EXPECT_THAT(error_of([&] { open(folder.path("a.log"), options); }), HasSubstr("--camera"));
}

void write_packed(const std::string& path, const std::string& text) {
  const gzFile file = gzopen(path.c_str(), "wb");
  gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
  gzclose(file);
}

TEST(CarmenLog, PackedReadsLikePlainAndACutFileGivesWhatIsWhole) {
  const ScratchFolder folder;
  std::string text = carmen_front;
  for (int k = 0; k < 2000; ++k) {
    std::vector<std::string> ranges;
    for (int beam = 0; beam < 20; ++beam) ranges.push_back(std::to_string((k * 7919 + beam * 104729) % 9973) + ".25");
    text += flaser(ranges, std::to_string(k) + " 0 0", std::to_string(k));
  }
  folder.write("plain.log", text);
  write_packed(folder.path("packed.log.gz"), text);
  write_packed(folder.path("cut.log.gz"), text);
  folder.truncate("cut.log.gz", 0.7);
  const auto plain = read_all(*open(folder.path("plain.log")));
  const auto packed = read_all(*open(folder.path("packed.log.gz")));
  ASSERT_EQ(plain.size(), 2000u);
  ASSERT_EQ(packed.size(), plain.size());
  for (std::size_t k = 0; k < plain.size(); k += 97) EXPECT_EQ(packed[k].scan->ranges, plain[k].scan->ranges);
  const auto source = open(folder.path("cut.log.gz"));
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("damaged or breaks off after")));
  const auto cut = read_all(*source);
  EXPECT_GT(cut.size(), 1000u);
  EXPECT_LT(cut.size(), 1999u);
  EXPECT_EQ(cut.back().stamp, (static_cast<TimeNs>(cut.size()) - 1) * ns_per_second);
}

TEST(LaserCheck, KnowsBeamsJumpsAndEmptyScans) {
  const ScratchFolder folder;
  std::string text;
  for (int k = 0; k < 20; ++k) {
    const std::string x = std::to_string(k == 12 ? 40.0 : 0.1 * k);
    const std::vector<std::string> ranges =
        k == 5 ? std::vector<std::string>{"0", "nan", "-1", "50"} : std::vector<std::string>{"1", "2", "3", "50"};
    text += flaser(ranges, x + " 0 0", std::to_string(10.0 + 0.1 * k));
  }
  folder.write("a.log", text);
  const auto report = check(folder.path("a.log"), {});
  EXPECT_TRUE(report.usable);
  EXPECT_EQ(report.frames_read, 20);
  EXPECT_NEAR(report.stamps.rate_hz, 10.0, 1e-6);
  EXPECT_NEAR(report.scans.returns_percent, 71.25, 1e-9);
  EXPECT_NEAR(report.scans.free_percent, 25.0, 1e-9);
  EXPECT_NEAR(report.scans.broken_percent, 3.75, 1e-9);
  EXPECT_THAT(report.scans.empty_scans, ElementsAre(5));
  ASSERT_EQ(report.odometry.odometry_jumps.size(), 2u);  // There and back.
  EXPECT_EQ(report.odometry.odometry_jumps[0].frame, 12);
  EXPECT_THAT(to_text(report), HasSubstr("scans         4 beams from -90.00 to 45.00 deg, 0 to 50 m"));
  EXPECT_THAT(to_text(report), HasSubstr("beams         71.2 % returns"));
  EXPECT_THAT(to_json(report), HasSubstr("\"odometry_jumps\""));
}

TEST(LaserCheck, ScansThatMeasureNothingAreUnusableAndBackwardStampsAreFound) {
  const ScratchFolder folder;
  std::string text;
  for (int k = 0; k < 4; ++k)
    text += flaser({"0", "0"}, std::to_string(k) + " 0 0", k == 2 ? "0.5" : std::to_string(k));
  folder.write("a.log", text);
  const auto report = check(folder.path("a.log"), {});
  EXPECT_FALSE(report.usable);
  EXPECT_THAT(report.reasons, Contains("no beam of any scan measured anything"));
  EXPECT_THAT(report.stamps.backward_stamps, ElementsAre(2));
}

std::string minesrover_line(std::size_t meta, const std::string& front, int range) {
  std::string line = front;
  for (std::size_t k = 0; k < meta; ++k) line += " 7";
  for (int beam = 0; beam < 682; ++beam) line += " " + std::to_string(beam == 340 ? range : 0);
  return line + "\n";
}

TEST(MinesroverLog, WheelsAreSummedUp) {
  const ScratchFolder folder;
  // 1000 counts of both wheels are 0.23 m ahead; then the right one alone turns the rover left about its left wheel.
  folder.write("a.dat", minesrover_line(21, "1000000 1 500 700", 1000) + minesrover_line(21, "1100000 1 1500 1700", 7) +
                            minesrover_line(21, "1200000 1 1500 2700", 1500));
  const auto source = open(folder.path("a.dat"));
  EXPECT_EQ(source->info().format, "minesrover");
  const auto frames = read_all(*source);
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1].stamp, 1'100'000'000);
  const LaserScan& scan = *frames[0].scan;
  EXPECT_EQ(scan.ranges[340], 1.0F);
  EXPECT_NEAR(scan.angle_of(340), 0.0, 1e-12);
  EXPECT_TRUE(scan.is_return(340) && !scan.is_return(0) && !scan.is_free(0));
  EXPECT_FALSE(frames[1].scan->is_return(340));  // 7 is a code of the scanner.
  EXPECT_NEAR(frames[1].odometry_from_body->translation().x(), 0.23, 1e-12);
  const double yaw = 0.23 / 0.33;
  EXPECT_NEAR(frames[2].odometry_from_body->rotation().angle(), yaw, 1e-12);
  EXPECT_NEAR(frames[2].odometry_from_body->translation().y(), 0.165 * (1.0 - std::cos(yaw)), 1e-12);
}

TEST(MinesroverLog, APoseIsTakenAsItStandsAndALineOfAnotherLengthIsBroken) {
  const ScratchFolder folder;
  folder.write("a.dat", minesrover_line(7, "1000000 1 2 -2.5 1.5 450", 1000) + "5 6 7\n" +
                            minesrover_line(7, "1200000 1 2 -2.0 1.5 450", 1000));
  const auto source = open(folder.path("a.dat"));
  std::vector<std::string> errors;
  const auto frames = read_all(*source, &errors);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_NEAR(frames[0].odometry_from_body->rotation().angle(), pi / 2.0, 1e-12);
  EXPECT_EQ(frames[0].odometry_from_body->translation(), Eigen::Vector2d(-2.5, 1.5));
  EXPECT_EQ(frames[1].index, 2);
  EXPECT_THAT(errors, ElementsAre(HasSubstr("a.dat:2: ")));
}

}  // namespace
}  // namespace rastro
