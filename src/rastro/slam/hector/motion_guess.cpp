// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/motion_guess.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace rastro {
namespace {

/// Odometry and stamps are not exact, not even when the robot stands still.
constexpr double least_sigma_m = 0.02, least_sigma_rad = 0.01;
/// A velocity estimate gets less reliable with its age.
constexpr double most_scans_ahead = 5.0;
/// The motion over a longer gap is unknown; the map must not grow because of a guess.
constexpr double longest_gap_s = 5.0;
constexpr std::size_t periods_kept = 15;

double seconds_between(TimeNs from, TimeNs to) { return 1e-9 * static_cast<double>(to - from); }

}  // namespace

ScanGuess MotionGuess::guess(TimeNs stamp, const std::optional<SE2>& odometry_from_body) {
  jumped_ = false;
  if (options_.guess == "none") return {last_, 0.2, 0.2, false};
  if (options_.guess == "constant-velocity" || !odometry_from_body || !last_odometry_) return from_speed(stamp);
  const SE2 moved = last_odometry_->inverse() * *odometry_from_body;
  const double distance_m = moved.translation().norm(), angle = std::abs(moved.rotation().angle());
  if (!(distance_m <=
        options_.max_speed_m_per_s * std::clamp(seconds_between(last_stamp_, stamp), 1.0, longest_gap_s)) ||
      !std::isfinite(angle)) {
    jumped_ = true;
    return from_speed(stamp);
  }
  return {last_ * moved, least_sigma_m + options_.odometry_sigma_share * distance_m,
          least_sigma_rad + options_.odometry_yaw_sigma_share * angle, true};
}

/// Scanners rotate evenly, but the stamps of some logs are irregular, so time is counted in scans.
double MotionGuess::scans_since_last(TimeNs stamp) const {
  if (periods_.size() < periods_kept) return 1.0;
  std::vector<double> sorted(periods_.begin(), periods_.end());
  std::nth_element(sorted.begin(), sorted.begin() + periods_kept / 2, sorted.end());
  const double scans = seconds_between(last_stamp_, stamp) / std::max(1e-3, sorted[periods_kept / 2]);
  return scans < 3.0 ? 1.0 : std::min(scans, most_scans_ahead);
}

ScanGuess MotionGuess::from_speed(TimeNs stamp) const {
  const Eigen::Vector3d step = scans_since_last(stamp) * step_;
  const SE2 moved(SO2::from_angle(step.z()), step.head<2>());
  return {last_ * moved, 0.05 + 0.5 * step.head<2>().norm(), 0.05 + 0.5 * std::abs(step.z()), true};
}

void MotionGuess::settle(TimeNs stamp, const std::optional<SE2>& odometry_from_body, const SE2& local_from_body) {
  if (started_) {
    const SE2 moved = last_.inverse() * local_from_body;
    step_ << moved.translation(), moved.rotation().angle();
    step_ /= scans_since_last(stamp);
    periods_.push_back(seconds_between(last_stamp_, stamp));
    if (periods_.size() > periods_kept) periods_.pop_front();
  }
  last_ = local_from_body;
  last_stamp_ = stamp;
  last_odometry_ = odometry_from_body;
  started_ = true;
}

}  // namespace rastro
