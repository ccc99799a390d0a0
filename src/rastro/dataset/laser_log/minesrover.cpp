// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/laser_log/minesrover.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "rastro/base/text.h"

namespace rastro {
namespace {

constexpr std::size_t beam_count = 682;
constexpr std::size_t columns_with_wheels = 25 + beam_count;
constexpr std::size_t columns_with_pose = 13 + beam_count;
constexpr double radians_per_degree = std::numbers::pi / 180.0;
constexpr double radians_per_step = 2.0 * std::numbers::pi / 1024.0;
constexpr double most_counts = 1e12;
constexpr double meters_per_count = 0.23e-3;
constexpr double meters_between_wheels = 0.33;
constexpr double meters_to_laser = 0.1;

std::size_t count_words(std::string_view line) {
  std::size_t count = 0;
  for (LogWords words(line, {}); words.next();) ++count;
  return count;
}

void skip(LogWords& words, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) words.next();
}

LaserScan read_scan(LogWords& words) {
  LaserScan scan;
  scan.first_angle = (44 - 384) * radians_per_step;
  scan.angle_step = radians_per_step;
  scan.min_range = 0.02;
  scan.max_range = 5.6;
  scan.body_from_laser = SE2(SO2(), {meters_to_laser, 0.0});
  scan.ranges.reserve(beam_count);
  for (std::size_t beam = 0; beam < beam_count; ++beam) {
    const double millimeters = words.number("a range");
    scan.ranges.push_back(static_cast<float>(std::clamp(millimeters, 0.0, 1e6) * 1e-3));
  }
  return scan;
}

}  // namespace

std::optional<Frame> MinesroverParser::read(std::string_view line, const LinePosition& position) {
  LogWords words(line, position);
  const std::size_t columns = count_words(line);
  if (columns == 0) return std::nullopt;
  if (columns != columns_with_wheels && columns != columns_with_pose)
    words.refuse(fmt::format("{} columns instead of {} or {}", columns, columns_with_wheels, columns_with_pose));
  Frame frame;
  frame.stamp = words.stamp("the time", StampUnit::microseconds);
  skip(words, columns == columns_with_wheels ? 1 : 2);
  if (columns == columns_with_wheels) {
    const double left = words.bounded("the left wheel", most_counts);
    integrate_wheels({left, words.bounded("the right wheel", most_counts)});
    frame.odometry_from_body = odometry_from_body_;
    skip(words, 21);
  } else {
    const double x = words.bounded("x", 1e9), y = words.bounded("y", 1e9), degrees = words.bounded("the heading", 1e9);
    frame.odometry_from_body = SE2(SO2::from_angle(degrees * radians_per_degree), {x, y});
    skip(words, 7);
  }
  frame.scan = read_scan(words);
  return frame;
}

void MinesroverParser::integrate_wheels(const Wheels& wheels) {
  if (last_wheels_) {
    const double left = (wheels.left - last_wheels_->left) * meters_per_count;
    const double right = (wheels.right - last_wheels_->right) * meters_per_count;
    odometry_from_body_ =
        odometry_from_body_ * SE2::exp({(left + right) / 2.0, 0.0, (right - left) / meters_between_wheels});
  }
  last_wheels_ = wheels;
}

void MinesroverParser::start_over(SourceInfo& info) {
  info.format = "minesrover";
  info.has_scan = true;
  info.has_odometry = true;
  last_wheels_.reset();
  odometry_from_body_ = SE2();
}

bool looks_like_minesrover(std::string_view front) {
  // The front may end within a line, so only one that has its end counts.
  const auto end = front.find('\n');
  if (end == std::string_view::npos) return false;
  const auto columns = split_words(trim(front.substr(0, end)));
  return (columns.size() == columns_with_wheels || columns.size() == columns_with_pose) &&
         std::all_of(columns.begin(), columns.end(), [](auto column) { return parse_finite(column).has_value(); });
}

}  // namespace rastro
