// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/laser_log/carmen.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "rastro/base/text.h"
#include "rastro/sensor/scan_text.h"

namespace rastro {
namespace {

constexpr std::size_t most_beams = 100'000;
constexpr double sick_max_range = 81.83;
constexpr double least_share_of_max_range = 0.001;  // Of the beams.

constexpr std::array<std::string_view, 6> other_scan_kinds = {"FLASER",      "ROBOTLASER1", "RLASER",
                                                              "ROBOTLASER2", "RAWLASER1",   "RAWLASER2"};
constexpr std::array<std::string_view, 9> known_words = {"PARAM",       "SYNC",    "ODOM",      "FLASER",     "RLASER",
                                                         "ROBOTLASER1", "TRUEPOS", "RAWLASER1", "ROBOTLASER2"};

template <typename Words>
bool is_one_of(std::string_view word, const Words& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Of 180, 360, ... beams over 180 degrees the one at the end is missing; 181, 361, ... have it.
double flaser_step(std::size_t beams) {
  const bool has_both_ends = beams % 2 == 1 && beams > 1;
  return std::numbers::pi / static_cast<double>(has_both_ends ? beams - 1 : std::max<std::size_t>(beams, 1));
}

/// As float, keeping what it means: at max_range or beyond it stays there, whatever the rounding.
float stored_range(double range, double max_range) {
  if (max_range > 0.0 && range >= max_range) return free_range(max_range);
  constexpr double largest = std::numeric_limits<float>::max();
  return static_cast<float>(std::isfinite(range) ? std::clamp(range, -largest, largest) : range);
}

void read_ranges(LogWords& words, LaserScan& scan, std::size_t beams) {
  scan.ranges.reserve(beams);
  for (std::size_t beam = 0; beam < beams; ++beam)
    scan.ranges.push_back(stored_range(words.number("a range"), scan.max_range));
}

/// What follows the time: the host and the logger's own time, which some tools omit.
void require_end(LogWords& words) {
  words.next();
  words.next();
  if (words.next()) words.refuse("more numbers than its count of ranges allows");
}

}  // namespace

std::optional<Frame> CarmenParser::read(std::string_view line, const LinePosition& position) {
  LogWords words(line, position);
  const auto kind = words.next();
  if (!kind) return std::nullopt;
  if (*kind == "PARAM") read_param(words);
  if (!is_one_of(*kind, other_scan_kinds)) return std::nullopt;
  if (kind_.empty() && (*kind == "FLASER" || *kind == "ROBOTLASER1")) kind_ = *kind;
  if (*kind != kind_) {
    ++other_scans_;
    other_kind_ = *kind;
    return std::nullopt;
  }
  Frame frame = kind_ == "FLASER" ? read_flaser(words) : read_robot_laser(words);
  if (!second_pass_) keep_statistics(*frame.scan, *frame.odometry_from_body);
  if (second_pass_ && !has_odometry_) frame.odometry_from_body.reset();
  return frame;
}

void CarmenParser::read_param(LogWords words) {
  const auto name = words.next();
  const auto value = words.next();
  if (!name || !value) return;
  const auto number = parse_finite(*value);
  if (!number) return;
  if (*name == "robot_frontlaser_offset") laser_offset_ = *number;
  if (*name == "robot_front_laser_max" && *number > 0.0) max_range_of_param_ = *number;
}

Frame CarmenParser::read_flaser(LogWords words) {
  Frame frame;
  LaserScan& scan = frame.scan.emplace();
  const auto beams = words.count("the number of ranges", most_beams);
  scan.first_angle = -std::numbers::pi / 2.0;
  scan.angle_step = flaser_step(beams);
  scan.max_range = max_range_;
  scan.body_from_laser = SE2(SO2(), {laser_offset_, 0.0});
  read_ranges(words, scan, beams);
  words.pose("the laser's pose");
  frame.odometry_from_body = words.pose("the odometry");
  frame.stamp = words.stamp("the time", StampUnit::seconds);
  require_end(words);
  return frame;
}

Frame CarmenParser::read_robot_laser(LogWords words) {
  Frame frame;
  LaserScan& scan = frame.scan.emplace();
  words.finite("the laser's type");
  scan.first_angle = words.finite("the first angle");
  const double field_of_view = words.finite("the field of view");
  scan.angle_step = words.finite("the angle's step");
  scan.max_range = words.finite("the largest range");
  if (scan.max_range <= 0.0) words.refuse("the largest range is not above 0");
  words.finite("the accuracy");
  words.finite("the remission's mode");
  const auto beams = words.count("the number of ranges", most_beams);
  if (scan.angle_step == 0.0 && beams > 1) scan.angle_step = field_of_view / static_cast<double>(beams - 1);
  read_ranges(words, scan, beams);
  const auto remissions = words.count("the number of remissions", most_beams);
  for (std::size_t k = 0; k < remissions; ++k) words.number("a remission");
  const SE2 odometry_from_laser = words.pose("the laser's pose");
  frame.odometry_from_body = words.pose("the robot's pose");
  scan.body_from_laser = frame.odometry_from_body->inverse() * odometry_from_laser;
  for (int k = 0; k < 5; ++k) words.finite("the velocities and distances");
  frame.stamp = words.stamp("the time", StampUnit::seconds);
  require_end(words);
  return frame;
}

void CarmenParser::keep_statistics(const LaserScan& scan, const SE2& odometry) {
  if (!first_odometry_) first_odometry_ = odometry;
  has_odometry_ = has_odometry_ || odometry.translation() != first_odometry_->translation() ||
                  odometry.rotation().angle() != first_odometry_->rotation().angle();
  beam_count_ += static_cast<std::int64_t>(scan.ranges.size());
  for (const float range : scan.ranges) {
    if (!std::isfinite(range) || range < largest_range_) continue;
    largest_range_count_ = range > largest_range_ ? 1 : largest_range_count_ + 1;
    largest_range_ = range;
  }
}

void CarmenParser::start_over(SourceInfo& info) {
  second_pass_ = true;
  const bool repeats =
      static_cast<double>(largest_range_count_) >= least_share_of_max_range * static_cast<double>(beam_count_);
  max_range_ = repeats && largest_range_ > 0.0F ? static_cast<double>(largest_range_)
               : max_range_of_param_ > 0.0      ? max_range_of_param_
                                                : sick_max_range;
  info.format = "carmen";
  info.has_scan = true;
  info.has_odometry = has_odometry_;
  if (!has_odometry_) info.warnings.push_back("the odometry is the same in all lines and is ignored");
  if (other_scans_ > 0)
    info.warnings.push_back(
        fmt::format("{} scans of another kind than {} are ignored, such as {}", other_scans_, kind_, other_kind_));
  other_scans_ = 0;
}

bool looks_like_carmen(std::string_view front) {
  for (const auto line : split(front, '\n')) {
    const auto words = split_words(line);
    if (words.size() > 1 && !line.starts_with('#')) return is_one_of(words.front(), known_words);
  }
  return false;
}

}  // namespace rastro
