// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "rastro/math/se2.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap.h"

namespace rastro {

/// Where a scan is, and how well that is known.
struct FollowedScan {
  SE2 local_from_body;
  double score = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of (x, y, angle), local axes.
  bool searched = false;                                 ///< The larger window was looked through.
  bool fits = false;                                     ///< False: the pose is the guess.
  std::optional<Eigen::Vector2d> unseen_direction;       ///< Unit vector along which the scan tells nothing.
};

/// What is expected before the scan is looked at.
struct ScanGuess {
  SE2 local_from_body;
  double sigma_m = 0.1, sigma_rad = 0.1;
  bool trusted = true;  ///< False: nothing but the last pose; it must not pull.
};

/// Matches scans one after the other to the map that grows with them (Kohlbrecher et al. 2011, section IV).
class ScanFollower {
 public:
  explicit ScanFollower(const HectorOptions& options) : options_(options) {}
  FollowedScan follow(Submap& map, std::span<const Eigen::Vector2d> points, const ScanGuess& guess) const;

 private:
  const HectorOptions& options_;
};

}  // namespace rastro
