// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/motion_guess.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "rastro/math/same_pose.h"

namespace rastro {
namespace {

/// Odometry and stamps are not exact, not even when the robot stands still.
constexpr double least_sigma_m = 0.02, least_sigma_rad = 0.01;
/// A velocity estimate gets less reliable with its age.
constexpr double most_scans_ahead = 5.0;
/// The motion over a longer gap is unknown; the map must not grow because of a guess.
constexpr double longest_gap_s = 5.0;
constexpr std::size_t periods_kept = 15;
/// Stamps of logs are irregular: a step may have taken longer than they say.
constexpr double longer_step = 1.5;
/// Odometry that stays the same to the last bit while this many scans moved is frozen.
constexpr int frozen_scans = 10;
constexpr double clear_step_m = 0.02, clear_step_rad = 0.02;
/// After this many jumps, each made up for by 20 plausible steps, odometry is used no more: its unit is wrong.
constexpr double most_distrust = 10.0, trust_of_step = 0.05;

Eigen::Vector3d vector_of(const SE2& moved) {
  return {moved.translation().x(), moved.translation().y(), moved.rotation().angle()};
}

double seconds_between(TimeNs from, TimeNs to) { return 1e-9 * static_cast<double>(to - from); }

}  // namespace

ScanGuess MotionGuess::guess(TimeNs stamp, const std::optional<SE2>& odometry_from_body) {
  jumped_ = false;
  growth_.setZero();
  if (options_.guess == "none") return {last_, 0.2, 0.2, false};
  if (options_.guess == "constant-velocity" || !odometry_from_body || !last_odometry_) return from_speed(stamp);
  // Its first step after that is of the whole time, which the scans have followed.
  if (unmoved_ >= frozen_scans) return from_speed(stamp);
  const SE2 measured = last_odometry_->inverse() * *odometry_from_body;
  const SE2 moved(measured.rotation(), scale_.factor() * measured.translation());
  const double distance_m = moved.translation().norm(), angle = std::abs(moved.rotation().angle());
  if (jumps(distance_m, stamp) || !std::isfinite(angle) || odometry_is_given_up()) {
    jumped_ = true;
    distrust_ += 1.0;
    return from_speed(stamp);
  }
  if (distance_m > 0.0) distrust_ = std::max(0.0, distrust_ - trust_of_step);
  growth_ << options_.odometry_sigma_share * distance_m, options_.odometry_yaw_sigma_share * angle;
  ScanGuess by_odometry = guess_at(moved, least_sigma_m, least_sigma_rad);
  by_odometry.measured = true;
  return by_odometry;
}

ScanGuess MotionGuess::guess_at(const SE2& moved, double least_m, double least_rad) const {
  const Eigen::Vector2d sigma = Eigen::Vector2d(least_m, least_rad) + growth_ + unseen_growth_;
  return {last_ * moved, sigma.x(), std::min(sigma.y(), std::numbers::pi), true};
}

bool MotionGuess::odometry_is_given_up() const { return distrust_ >= most_distrust; }

/// Faster than a vehicle drives. While the period of the scans is unknown, within a second; the mean one, since stamps
/// may be of whole seconds.
bool MotionGuess::jumps(double distance_m, TimeNs stamp) const {
  constexpr std::size_t fewest_periods = 3;
  const double mean_s = std::accumulate(periods_.begin(), periods_.end(), 0.0) /
                        static_cast<double>(std::max<std::size_t>(1, periods_.size()));
  const double shortest = periods_.size() < fewest_periods ? 1.0 : std::clamp(longer_step * mean_s, 0.05, 1.0);
  const double seconds = std::clamp(seconds_between(last_stamp_, stamp), shortest, longest_gap_s);
  return !(distance_m <= options_.max_speed_m_per_s * seconds);
}

/// Median of the last ones.
double MotionGuess::period_s() const {
  std::vector<double> sorted(periods_.begin(), periods_.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return std::max(1e-3, *middle);
}

/// Some logs have the time at which a scan was read: several at once, the next one late, or out of order. Missing scans
/// make periods longer, but none shorter than that of the scanner.
bool MotionGuess::stamps_tell_scans() const {
  constexpr double shortest_period_s = 0.005, most_ratio = 5.0;
  std::vector<double> sorted(periods_.begin(), periods_.end());
  std::sort(sorted.begin(), sorted.end());
  const double shorter = sorted[sorted.size() / 5], longer = sorted[3 * sorted.size() / 4];
  return sorted.front() > 0.0 && sorted[sorted.size() / 2] > shortest_period_s && longer < most_ratio * shorter;
}

/// Scanners rotate evenly, so time is counted in scans, where stamps tell them.
double MotionGuess::scans_since_last(TimeNs stamp) const {
  if (periods_.size() < periods_kept || !stamps_tell_scans()) return 1.0;
  const double scans = seconds_between(last_stamp_, stamp) / period_s();
  return scans < 3.0 ? 1.0 : std::min(scans, most_scans_ahead);
}

double MotionGuess::gap_s(TimeNs stamp) const { return many_periods_s(last_seen_stamp_, stamp); }

/// 0 if they are few.
double MotionGuess::many_periods_s(TimeNs from, TimeNs to) const {
  constexpr double shortest_s = 1.0, shortest_periods = 10.0;
  if (periods_.size() < periods_kept) return 0.0;
  const double seconds = seconds_between(from, to);
  return seconds > shortest_s && seconds > shortest_periods * period_s() ? seconds : 0.0;
}

ScanGuess MotionGuess::from_speed(TimeNs stamp) {
  constexpr double least_m = 0.05, least_rad = 0.05;
  const Eigen::Vector3d step = scans_since_last(stamp) * step_;
  const SE2 moved(SO2::from_angle(step.z()), step.head<2>());
  // It may have gone on all the time, or stopped.
  const double missing_s = many_periods_s(last_stamp_, stamp);
  const double scans = missing_s > 0.0 ? missing_s / period_s() : scans_since_last(stamp);
  const double beyond = std::max(0.0, scans - scans_since_last(stamp));
  growth_ << 0.5 * step.head<2>().norm() + beyond * step_.head<2>().norm(),
      0.5 * std::abs(step.z()) + beyond * std::abs(step_.z());
  return guess_at(moved, least_m, least_rad);
}

void MotionGuess::watch_odometry(const SE2& odometry_from_body, const SE2& moved) {
  if (!last_odometry_ || !same_pose(*last_odometry_, odometry_from_body)) {
    unmoved_ = 0;
  } else if (moved.translation().norm() > clear_step_m || std::abs(moved.rotation().angle()) > clear_step_rad) {
    ++unmoved_;
  }
}

/// Odometry may have jumped because of its scale, until that is known.
void MotionGuess::learn_scale(const SE2& odometry_from_body, const SE2& moved) {
  if (!last_odometry_) return;
  const double before = scale_.factor();
  scale_.add((last_odometry_->inverse() * odometry_from_body).translation(), moved.translation());
  if (before == 1.0 && scale_.factor() != 1.0) distrust_ = 0.0;
}

void MotionGuess::settle(TimeNs stamp, const std::optional<SE2>& odometry_from_body, const SE2& local_from_body,
                         bool by_scan) {
  // The step from a guess to a scan also holds what the guess was wrong by.
  const bool between_scans = started_ && by_scan && last_stamp_ == last_seen_stamp_;
  if (between_scans && odometry_from_body) learn_scale(*odometry_from_body, last_.inverse() * local_from_body);
  const bool from_guess = unseen_frames_ > 0;
  const double scans = scans_since_last(stamp) + unseen_frames_;
  remember(stamp, odometry_from_body, local_from_body);
  if (from_guess) step_ = vector_of(last_seen_.inverse() * local_from_body) / scans;
  unseen_growth_.setZero();
  unseen_frames_ = 0;
  last_seen_ = local_from_body;
  last_seen_stamp_ = stamp;
}

void MotionGuess::settle_unseen(TimeNs stamp, const std::optional<SE2>& odometry_from_body,
                                const SE2& local_from_body) {
  remember(stamp, odometry_from_body, local_from_body);
  unseen_growth_ += growth_;
  ++unseen_frames_;
}

void MotionGuess::remember(TimeNs stamp, const std::optional<SE2>& odometry_from_body, const SE2& local_from_body) {
  if (started_) {
    const SE2 moved = last_.inverse() * local_from_body;
    if (odometry_from_body) watch_odometry(*odometry_from_body, moved);
    step_ = vector_of(moved) / scans_since_last(stamp);
    if (jumps(moved.translation().norm(), stamp)) step_.setZero();
    periods_.push_back(seconds_between(last_stamp_, stamp));
    if (periods_.size() > periods_kept) periods_.pop_front();
  }
  last_ = local_from_body;
  last_stamp_ = stamp;
  last_odometry_ = odometry_from_body;
  started_ = true;
}

}  // namespace rastro
