// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/laser_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "rastro/input_check/share_near.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

// A scan that repeats to the last bit while the wheels move at least this far is stuck.
constexpr std::int64_t least_repeats = 5;
constexpr double stuck_m = 0.5, stuck_rad = 0.35;
constexpr int returns_of_a_scan = 20;
// Motion by odometry after which scans are compared; a longer one is a jump, or scans are missing.
constexpr double compared_m = 0.4, compared_rad = 0.3, longest_m = 1.5, largest_rad = 0.9;
constexpr double clear_m = 0.25, clear_rad = 0.15;
constexpr double least_observed = 0.15;  // Of the direction of motion; along a corridor nothing is known.
constexpr int least_yaws = 4, least_forwards = 6;
constexpr std::size_t least_ratios = 8;
constexpr double most_ratio = 1.35, least_agreeing = 0.6, most_right = 0.15;

int returns_in(const LaserScan& scan) {
  int returns = 0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) returns += scan.is_return(beam) ? 1 : 0;
  return returns;
}

/// To the last bit, whatever the values are.
bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace

bool LaserCheck::Tally::take() {
  constexpr std::int64_t all_until = 24, fourth_until = 96;
  const std::int64_t step = met < all_until ? 1 : met < fourth_until ? 4 : 16;
  return met++ % step == 0;
}

void LaserCheck::add(const Frame& frame, InputWarnings& found) {
  if (!frame.scan) return;
  check_unit(frame, found);
  if (!frame.odometry_from_body) return;
  check_stuck(frame, found);
  if (repeats_ > 0) return;
  compare_motion(frame);
  judge(found);
}

/// No 2D laser measures hundreds of meters: such ranges are millimeters or centimeters.
void LaserCheck::check_unit(const Frame& frame, InputWarnings& found) {
  constexpr float farthest_m = 300.0F;
  constexpr int enough_scans = 5;
  if (unit_wrong_) return;
  std::vector<double> ranges;
  for (const float range : frame.scan->ranges)
    if (std::isfinite(range) && range > 0.0F) ranges.push_back(static_cast<double>(range));
  if (ranges.size() < static_cast<std::size_t>(returns_of_a_scan)) return;
  const double middle = upper_median(ranges);
  scans_too_far_ = middle > static_cast<double>(farthest_m) ? scans_too_far_ + 1 : 0;
  if (scans_too_far_ < enough_scans) return;
  unit_wrong_ = true;
  found.push_back({"laser_unit", fmt::format("half of the ranges are beyond {:.0f}: meters are expected; are they in "
                                             "millimeters or centimeters?",
                                             middle)});
}

void LaserCheck::check_stuck(const Frame& frame, InputWarnings& found) {
  if (last_ranges_.empty() || !same_bits(last_ranges_, frame.scan->ranges)) {
    last_ranges_ = frame.scan->ranges;
    odometry_at_change_ = *frame.odometry_from_body;
    first_repeated_ = frame.index;
    repeats_ = 0;
    return;
  }
  ++repeats_;
  const SE2 moved = odometry_at_change_.inverse() * *frame.odometry_from_body;
  const double meters = moved.translation().norm(), radians = std::abs(moved.rotation().angle());
  if (stuck_ || repeats_ < least_repeats || (meters < stuck_m && radians < stuck_rad)) return;
  if (returns_in(*frame.scan) < returns_of_a_scan) return;
  stuck_ = true;
  found.push_back({"laser_stuck",
                   fmt::format("the scan has not changed since frame {}: {} equal scans while odometry moved {:.2f} m "
                               "and {:.0f} deg; is the laser stuck, or its data repeated?",
                               first_repeated_, repeats_ + 1, meters, radians * 180.0 / std::numbers::pi)});
}

void LaserCheck::compare_motion(const Frame& frame) {
  if (direction_wrong_ || scale_wrong_) return;
  if (reference_) {
    const SE2 motion = reference_->odometry_from_body.inverse() * *frame.odometry_from_body;
    const double meters = motion.translation().norm(), radians = std::abs(motion.rotation().angle());
    if (meters < compared_m && radians < compared_rad) return;
    if (meters <= longest_m && radians <= largest_rad && (radians >= clear_rad ? yaw_ : forward_).take()) {
      if (const auto fit = reference_->scan.match(*frame.scan, 2.2 * meters + 0.2, 1.3 * radians + 0.1))
        count(motion, *fit);
    }
  }
  reference_.emplace(Reference{ScanMotion(*frame.scan), *frame.odometry_from_body});
}

void LaserCheck::count(const SE2& by_odometry, const ScanMotionFit& by_scans) {
  const double yaw = by_odometry.rotation().angle(), yaw_ratio = by_scans.first_from_second.rotation().angle() / yaw;
  if (std::abs(yaw) >= clear_rad) {
    yaw_.same += yaw_ratio > 0.5 && yaw_ratio < 1.6 ? 1 : 0;
    yaw_.opposite += yaw_ratio < -0.5 && yaw_ratio > -1.6 ? 1 : 0;
  }
  const double meters = by_odometry.translation().norm();
  if (meters < clear_m) return;
  const Eigen::Vector2d direction = by_odometry.translation() / meters;
  if (direction.dot(by_scans.observed * direction) < least_observed) return;
  const double ratio = direction.dot(by_scans.first_from_second.translation()) / meters;
  forward_.same += ratio > 0.4 && ratio < 2.3 ? 1 : 0;
  forward_.opposite += ratio < -0.4 && ratio > -2.3 ? 1 : 0;
  ratios_.push_back(ratio);
}

void LaserCheck::judge(InputWarnings& found) {
  if (direction_wrong_ || scale_wrong_) return;
  judge_direction(found);
  if (!direction_wrong_) judge_scale(found);
}

void LaserCheck::judge_direction(InputWarnings& found) {
  const bool turns_reversed = yaw_.reversed(least_yaws), path_reversed = forward_.reversed(least_forwards / 2);
  const bool forward_right = forward_.same >= least_forwards / 2 && forward_.same >= 5 * forward_.opposite;
  if (path_reversed && (turns_reversed || (forward_.reversed(least_forwards) && yaw_.same == 0))) {
    direction_wrong_ = true;
    found.push_back(
        {"odometry_reversed",
         fmt::format("odometry runs against the scans: {} of {} motions and {} of {} rotations have the "
                     "opposite direction; check the sign of the odometry",
                     forward_.opposite, forward_.same + forward_.opposite, yaw_.opposite, yaw_.same + yaw_.opposite)});
  } else if (turns_reversed && (forward_right || yaw_.reversed(3 * least_yaws))) {
    direction_wrong_ = true;
    found.push_back({"laser_mirrored",
                     fmt::format("the scans rotate against the odometry: {} of {} rotations have the opposite "
                                 "direction; check the order of the beams (is the laser mounted upside down?), then "
                                 "the sign of the odometry's yaw",
                                 yaw_.opposite, yaw_.same + yaw_.opposite)});
  }
}

void LaserCheck::judge_scale(InputWarnings& found) {
  if (ratios_.size() < least_ratios) return;
  const double ratio = upper_median(ratios_);
  if (ratio <= 0.0 || (ratio < most_ratio && ratio > 1.0 / most_ratio)) return;
  if (share_near(ratios_, ratio) < least_agreeing || share_near(ratios_, 1.0) > most_right) return;
  scale_wrong_ = true;
  found.push_back(
      {"laser_scale",
       fmt::format("{} motions between scans are {:.2f} times as long as by odometry: check the unit of the "
                   "ranges, or the scale of the odometry",
                   ratios_.size(), ratio)});
}

}  // namespace rastro
