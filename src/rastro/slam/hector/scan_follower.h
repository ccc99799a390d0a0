// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "rastro/math/se2.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap.h"

namespace rastro {

/// The estimated pose of a scan and its uncertainty.
struct FollowedScan {
  SE2 local_from_body;
  double score = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of (x, y, angle), local axes.
  bool searched = false;                                 ///< The larger window was searched.
  bool fits = false;                                     ///< False: the pose is the guess.
  std::optional<Eigen::Vector2d> unseen_direction;       ///< Unit vector along which the scan gives no constraint.
  bool sees_all_directions = false;                      ///< The scan alone determined the position.
};

/// The predicted pose before the scan is matched.
struct ScanGuess {
  SE2 local_from_body;
  double sigma_m = 0.1, sigma_rad = 0.1;
  bool trusted = true;  ///< False: the guess is only the last pose and must not act as a prior.
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
