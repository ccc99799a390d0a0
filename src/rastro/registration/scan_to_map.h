// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "rastro/map/grid/log_odds_grid.h"
#include "rastro/math/se2.h"

namespace rastro {

struct ScanToMapOptions {
  int iterations = 8;               ///< Gauss-Newton steps at most, on each level.
  double smallest_step_m = 0.0005;  ///< A smaller step (a radian counts as a metre here) ends a level.
};

/// What is known of the pose before the scan is looked at: map_from_body is near `pose` with this information (inverse
/// covariance) of (x, y, angle), in units of the sum of squares of 1 - M.
struct ScanPrior {
  SE2 pose;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

struct ScanToMapFit {
  SE2 map_from_body;
  /// Sum of g g^T over the beams, g the derivative of the map at the beam's end by (x, y, angle), without the prior.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double score = 0.0;              ///< Mean of the map at the beams' ends, 0..1.
  double residual_variance = 0.0;  ///< Of 1 - M over the beams.
};

/// Moves the scan until its ends lie on what the map has as occupied: Gauss-Newton on the sum of (1 - M(end))^2, coarse
/// to fine, with M interpolated between cells (Kohlbrecher et al. 2011, equations 4 to 12). `levels`: the finest first.
/// `points`: the returns in the body frame, metres. nullopt without points or levels; where the
/// map knows nothing, the guess stays and the score is that of the unknown, 128/255.
std::optional<ScanToMapFit> match_scan_to_map(std::span<const ProbabilityView> levels,
                                              std::span<const Eigen::Vector2d> points, const SE2& guess,
                                              const ScanPrior* prior, const ScanToMapOptions& options);

/// Mean of the map at the ends, 0..1, with the points where the pose puts them.
double score_of(const ProbabilityView& map, std::span<const Eigen::Vector2d> points, const SE2& map_from_body);

}  // namespace rastro
