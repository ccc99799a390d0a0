// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "rastro/map/grid/log_odds_grid.h"
#include "rastro/math/se2.h"

namespace rastro {

struct ScanToMapOptions {
  int iterations = 8;               ///< Gauss-Newton iterations per level, at most.
  double smallest_step_m = 0.0005;  ///< Step size that ends a level (a radian counts as a meter).
};

/// Prior on the pose: map_from_body is near `pose` with this information (inverse covariance) of (x, y, angle), in
/// units of the sum of squares of 1 - M.
struct ScanPrior {
  SE2 pose;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

struct ScanToMapFit {
  SE2 map_from_body;
  /// Sum of g g^T over the beams, g the derivative of the map at the beam's endpoint by (x, y, angle), without the
  /// prior.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double score = 0.0;              ///< Mean of the map at the beams' endpoints, 0..1.
  double residual_variance = 0.0;  ///< Variance of 1 - M over the beams.
  int mapped = 0;          ///< Endpoints where anything is known of the map; the others say nothing about the pose.
  double agreement = 0.0;  ///< Mean of the map at these, 0..1.
};

/// Scan-to-map matching: aligns the scan's endpoints with the map's occupied cells. Gauss-Newton on the sum of (1 -
/// M(endpoint))^2, coarse to fine, with M interpolated between cells (Kohlbrecher et al. 2011, equations 4 to 12).
/// `levels`: the finest first. `points`: the returns in the body frame, meters. nullopt without points or levels. In
/// unknown parts of the map the guess stays and the score is that of unknown cells, 128/255; `mapped` tells them.
std::optional<ScanToMapFit> match_scan_to_map(std::span<const ProbabilityView> levels,
                                              std::span<const Eigen::Vector2d> points, const SE2& guess,
                                              const ScanPrior* prior, const ScanToMapOptions& options);

/// The points that end in or beside a cell that is rather occupied than free, in their order.
std::vector<Eigen::Vector2d> agreeing_points(const ProbabilityView& map, std::span<const Eigen::Vector2d> points,
                                             const SE2& map_from_body);

/// Mean of the map at the endpoints, 0..1, for the points at this pose.
double score_of(const ProbabilityView& map, std::span<const Eigen::Vector2d> points, const SE2& map_from_body);

}  // namespace rastro
