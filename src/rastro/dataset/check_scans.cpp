// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/check_scans.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/dataset/describe.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

// Wheels that are said to go faster than this did not: something else changed the numbers.
constexpr double least_jump_m = 0.5;
constexpr double least_jump_speed = 3.0;  // m/s
constexpr double jump_over_median_speed = 10.0;
constexpr double least_jump_rad = 0.5;
constexpr double least_jump_rate = 2.0 * std::numbers::pi;  // rad/s

bool same_geometry(const LaserScan& a, const LaserScan& b) {
  return a.ranges.size() == b.ranges.size() && a.first_angle == b.first_angle && a.angle_step == b.angle_step &&
         a.max_range == b.max_range;
}

double percent(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

void ScanCheck::add(const Frame& frame) {
  if (frame.scan) check_scan(frame.index, *frame.scan);
  if (frame.odometry_from_body) check_odometry(frame);
  report_.landmark_observations += static_cast<std::int64_t>(frame.landmarks.size());
  for (const auto& landmark : frame.landmarks)
    if (landmark.id >= 0) landmarks_.insert(landmark.id);
}

void ScanCheck::check_scan(std::int64_t index, const LaserScan& scan) {
  if (!report_.scans.first_scan) {
    report_.scans.first_scan = scan;
  } else if (!same_geometry(scan, *report_.scans.first_scan)) {
    report_.size_changes.push_back({index, fmt::format("the scan has {}, those before it {}", describe_scan(scan),
                                                       describe_scan(*report_.scans.first_scan))});
  }
  std::int64_t returns = 0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    returns += scan.is_return(beam) ? 1 : 0;
    free_ += scan.is_free(beam) ? 1 : 0;
  }
  beams_ += static_cast<std::int64_t>(scan.ranges.size());
  returns_ += returns;
  if (returns == 0) report_.scans.empty_scans.push_back(index);
}

void ScanCheck::check_odometry(const Frame& frame) {
  ++report_.odometry.frames_with_odometry;
  if (last_odometry_) {
    const SE2 step = last_odometry_->inverse() * *frame.odometry_from_body;
    steps_.push_back({frame.index, step.translation().norm(), std::abs(step.rotation().angle()),
                      static_cast<double>(frame.stamp) * 1e-9 - static_cast<double>(last_stamp_) * 1e-9});
    report_.odometry.odometry_length_m += steps_.back().meters;
  }
  last_odometry_ = frame.odometry_from_body;
  last_stamp_ = frame.stamp;
}

void ScanCheck::find_jumps() {
  std::vector<double> speeds;
  for (const auto& step : steps_)
    if (step.seconds > 0.0) speeds.push_back(step.meters / step.seconds);
  if (speeds.empty()) return;
  const double limit = std::max(least_jump_speed, jump_over_median_speed * upper_median(std::move(speeds)));
  for (const auto& step : steps_) {
    const bool leaps = step.meters > least_jump_m && step.meters > limit * step.seconds;
    const bool spins = step.radians > least_jump_rad && step.radians > least_jump_rate * step.seconds;
    if (leaps || spins)
      report_.odometry.odometry_jumps.push_back(
          {step.frame, fmt::format("{:.2f} m and {:.1f} deg in {:.3f} s", step.meters,
                                   step.radians * 180.0 / std::numbers::pi, step.seconds)});
  }
}

void ScanCheck::finish() {
  report_.scans.returns_percent = percent(returns_, beams_);
  report_.scans.free_percent = percent(free_, beams_);
  report_.scans.broken_percent = percent(beams_ - returns_ - free_, beams_);
  report_.landmarks = static_cast<std::int64_t>(landmarks_.size());
  find_jumps();
  if (report_.scans.first_scan && returns_ == 0) report_.reasons.push_back("no beam of any scan measured anything");
  if (!report_.scans.empty_scans.empty() && returns_ > 0)
    report_.warnings.push_back(fmt::format("{} scans have not one return", report_.scans.empty_scans.size()));
  if (!report_.odometry.odometry_jumps.empty())
    report_.warnings.push_back(fmt::format("{} jumps of the odometry", report_.odometry.odometry_jumps.size()));
}

}  // namespace rastro
