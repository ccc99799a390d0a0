// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/map/grid/log_odds_grid.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/laser_scan.h"

namespace rastro {

struct ScanMotionFit {
  SE2 first_from_second;  ///< Motion of the body between both scans.
  double score = 0.0;     ///< 0..1, how well they fit.
  /// Of the surfaces, normalized to a largest eigenvalue of 1: how well each direction is observed.
  Eigen::Matrix2d observed = Eigen::Matrix2d::Zero();
};

/// One scan as a map in which others are searched, without any guess of the motion.
class ScanMotion {
 public:
  explicit ScanMotion(const LaserScan& scan);

  /// The motion to `scan` within `reach_m` and `reach_rad` of none; nullopt where the scans have too few returns or do
  /// not fit.
  std::optional<ScanMotionFit> match(const LaserScan& scan, double reach_m, double reach_rad) const;

 private:
  ProbabilityView view() const;
  void draw(const Eigen::Vector2d& point);

  std::vector<Eigen::Vector2d> points_;
  int width_ = 0, height_ = 0;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  std::vector<std::uint8_t> cells_;
};

}  // namespace rastro
