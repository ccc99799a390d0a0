// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "rastro/math/se2.h"
#include "rastro/registration/correlative_search.h"
#include "rastro/registration/scan_to_map.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap.h"

namespace rastro {

/// The estimated pose of a scan and its uncertainty.
struct FollowedScan {
  SE2 local_from_body;
  double score = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of the match, (x, y, angle), local axes.
  /// What the guess adds to it where the pose is partly the scan's and partly the guess's.
  Eigen::Matrix3d guess_covariance = Eigen::Matrix3d::Zero();
  bool searched = false;  ///< The larger window was searched.
  bool fits = false;      ///< Nothing contradicts the pose. False: it is the guess.
  double needs = 0.0;     ///< The score that it had to reach.
  bool unmapped = false;  ///< It fits, but where too little is mapped to tell: the pose is the guess.
  int mapped = 0;         ///< Returns that lie where the map is known.
  std::optional<Eigen::Vector2d> unseen_direction =
      std::nullopt;                  ///< Unit vector along which the scan gives no constraint.
  bool sees_all_directions = false;  ///< The scan alone determined the position.
};

/// The predicted pose before the scan is matched.
struct ScanGuess {
  SE2 local_from_body;
  double sigma_m = 0.1, sigma_rad = 0.1;
  bool trusted = true;      ///< False: the guess is only the last pose and must not act as a prior.
  bool measured = false;    ///< By odometry; else the motion is assumed to go on as it was.
  bool after_gap = false;   ///< What comes is mapped apart from what was mapped before.
  bool after_loss = false;  ///< The last scan matched nowhere: what fits a little may be anywhere.
};

/// Matches scans one after the other to the map that grows with them (Kohlbrecher et al. 2011, section IV).
class ScanFollower {
 public:
  explicit ScanFollower(const HectorOptions& options) : options_(options) {}
  FollowedScan follow(Submap& map, std::span<const Eigen::Vector2d> points, const ScanGuess& guess) const;

 private:
  bool unmapped(const ScanToMapFit& fit) const { return fit.mapped < options_.min_returns; }
  bool contradicted(const ScanToMapFit& fit, std::size_t points) const;
  bool clear(const ScanToMapFit& fit) const { return fit.agreement >= options_.loop_min_score; }
  CorrelativeWindow window(const ScanGuess& guess, bool doubtful) const;
  std::optional<ScanToMapFit> searched(Submap& map, std::span<const Eigen::Vector2d> points, const ScanGuess& guess,
                                       bool doubtful) const;
  void keep_guess_where_unseen(std::span<const Eigen::Vector2d> points, const ScanGuess& guess,
                               FollowedScan& followed) const;

  const HectorOptions& options_;
};

}  // namespace rastro
