// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/odometry_check.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "rastro/math/median.h"
#include "rastro/math/same_pose.h"

namespace rastro {
namespace {

double seconds_between(TimeNs from, TimeNs to) { return 1e-9 * static_cast<double>(to - from); }

}  // namespace

void OdometryCheck::add(const Frame& frame, InputWarnings& found) {
  if (!frame.odometry_from_body) return;
  check_speed(frame, found);
  if (frame.scan) check_still(frame, found);
  last_ = frame.odometry_from_body;
  last_stamp_ = frame.stamp;
}

void OdometryCheck::check_speed(const Frame& frame, InputWarnings& found) {
  constexpr std::size_t enough_steps = 40;
  constexpr double fastest_m_per_s = 40.0;
  if (!last_ || frame.stamp <= last_stamp_ || speeds_.size() >= enough_steps) return;
  const double meters = (last_->inverse() * *frame.odometry_from_body).translation().norm();
  if (!(meters > 0.0)) return;
  speeds_.push_back(meters / seconds_between(last_stamp_, frame.stamp));
  if (speeds_.size() < enough_steps) return;
  const double usual = upper_median(speeds_);
  if (!(usual > fastest_m_per_s)) return;
  found.push_back({"odometry_unit", fmt::format("odometry moves at {:.0f} m/s: is it in millimeters or centimeters, or "
                                                "are the stamps in another unit?",
                                                usual)});
}

/// While the odometry stays the same to the last bit, every fifth scan is compared with the one where that began.
void OdometryCheck::check_still(const Frame& frame, InputWarnings& found) {
  constexpr int step = 5, most_compared = 200;
  constexpr double shortest_s = 1.5;
  if (told_still_) return;
  still_frames_ = last_ && same_pose(*last_, *frame.odometry_from_body) ? still_frames_ + 1 : 0;
  if (still_frames_ == 2) {
    still_scan_.emplace(*frame.scan);
    still_since_ = frame.stamp, first_still_ = frame.index, still_moved_ = 0;
  }
  if (still_frames_ <= 2 || still_frames_ % step != 0 || still_frames_ > most_compared) return;
  still_moved_ = moved_clearly(*frame.scan) ? still_moved_ + 1 : 0;
  const double seconds = seconds_between(still_since_, frame.stamp);
  if (still_moved_ < 2 || seconds < shortest_s) return;
  told_still_ = true;
  found.push_back({"odometry_stuck",
                   fmt::format("odometry has not changed since frame {}, in {:.1f} s, while the scans moved {:.2f} m "
                               "and {:.0f} deg: are its messages missing?",
                               first_still_, seconds, moved_m_, moved_rad_ * 180.0 / std::numbers::pi)});
}

/// Along a corridor nothing is known.
bool OdometryCheck::moved_clearly(const LaserScan& scan) {
  constexpr double reach_m = 1.5, reach_rad = 0.6, clear_m = 0.3, clear_rad = 0.25, least_observed = 0.15;
  const auto fit = still_scan_->match(scan, reach_m, reach_rad);
  if (!fit) return false;
  const Eigen::Vector2d moved = fit->first_from_second.translation();
  moved_m_ = moved.norm(), moved_rad_ = std::abs(fit->first_from_second.rotation().angle());
  const bool seen = moved.dot(fit->observed * moved) >= least_observed * moved.squaredNorm();
  return (moved_m_ >= clear_m && seen) || moved_rad_ >= clear_rad;
}

}  // namespace rastro
