// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "rastro/base/time.h"
#include "rastro/math/se2.h"
#include "rastro/slam/hector/odometry_scale.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/scan_follower.h"

namespace rastro {

/// Predicts the pose of the next scan: from odometry, from constant velocity, or as the last pose.
class MotionGuess {
 public:
  explicit MotionGuess(const HectorOptions& options) : options_(options) {}

  ScanGuess guess(TimeNs stamp, const std::optional<SE2>& odometry_from_body);
  /// Whether the last guess discarded its odometry because no vehicle moves like that.
  bool odometry_jumped() const { return jumped_; }
  /// Whether odometry is used no more, because it jumped too often: its unit is wrong, or it is that of another drive.
  bool odometry_is_given_up() const;
  /// `by_scan`: the scan alone determined the pose, so that it tells whether odometry is right.
  void settle(TimeNs stamp, const std::optional<SE2>& odometry_from_body, const SE2& local_from_body,
              bool by_scan = false);
  /// As settle(), for a frame whose scan tells nothing: `local_from_body` is the guess, whose errors the next one has
  /// too.
  void settle_unseen(TimeNs stamp, const std::optional<SE2>& odometry_from_body, const SE2& local_from_body);
  /// Meters that the robot moves where odometry says one; 1 unless scans clearly say otherwise.
  double odometry_scale() const { return scale_.factor(); }
  /// What odometry, scaled so, may be wrong by where scans do not tell.
  OdometryError odometry_error() const { return scale_.error(options_.odometry_sigma_share); }
  /// Seconds since the last scan that told a pose; 0 unless they are many periods.
  double gap_s(TimeNs stamp) const;
  const SE2& last() const { return last_; }

 private:
  ScanGuess from_speed(TimeNs stamp);
  ScanGuess guess_at(const SE2& moved, double least_m, double least_rad) const;
  void remember(TimeNs stamp, const std::optional<SE2>& odometry_from_body, const SE2& local_from_body);
  double many_periods_s(TimeNs from, TimeNs to) const;
  double period_s() const;
  bool stamps_tell_scans() const;
  double scans_since_last(TimeNs stamp) const;
  bool jumps(double distance_m, TimeNs stamp) const;
  void watch_odometry(const SE2& odometry_from_body, const SE2& moved);
  void learn_scale(const SE2& odometry_from_body, const SE2& moved);

  const HectorOptions& options_;
  SE2 last_, last_seen_;  ///< Of the last frame, and of the last scan that told a pose.
  std::optional<SE2> last_odometry_;
  OdometryScale scale_;
  Eigen::Vector3d step_ = Eigen::Vector3d::Zero();  ///< From one scan to the next, body frame, meters and radians.
  TimeNs last_stamp_ = 0, last_seen_stamp_ = 0;     ///< The same.
  int unseen_frames_ = 0;                           ///< Since that scan.
  /// Growth of sigma with the motion, meters and radians: of the last guess, and over the frames since that scan.
  Eigen::Vector2d growth_ = Eigen::Vector2d::Zero(), unseen_growth_ = Eigen::Vector2d::Zero();
  std::deque<double> periods_;  ///< Seconds between the last scans.
  int unmoved_ = 0;             ///< Scans that moved while the odometry stayed the same to the last bit.
  double distrust_ = 0.0;       ///< Jumps of odometry, less what it moved plausibly.
  bool started_ = false, jumped_ = false;
};

}  // namespace rastro
