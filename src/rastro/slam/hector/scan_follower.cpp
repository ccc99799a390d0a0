// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/scan_follower.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

#include "rastro/registration/scan_to_map.h"

namespace rastro {
namespace {

/// Variance of 1 - M near a good pose: weights the guess's sigma against the beams.
constexpr double usual_variance = 0.1;

ScanPrior prior_of(const ScanGuess& guess, const SE2& submap_from_body) {
  ScanPrior prior;
  prior.pose = submap_from_body;
  if (!guess.trusted) return prior;
  const double position_information = usual_variance / (guess.sigma_m * guess.sigma_m);
  const double yaw_information = usual_variance / (guess.sigma_rad * guess.sigma_rad);
  prior.information.diagonal() << position_information, position_information, yaw_information;
  return prior;
}

/// The direction parallel to most surfaces, body frame, and the share of surfaces across it.
struct WeakDirection {
  Eigen::Vector2d direction;
  double share;
};

/// Determined from the scan alone, because the cells of a map are never as smooth as a wall. `points` in the order of
/// the beams.
WeakDirection weak_direction(std::span<const Eigen::Vector2d> points) {
  constexpr double base_m = 0.3, gap_m = 0.5;
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0, j = 0; i < points.size(); ++i) {
    // The base must be long enough, or range noise would rotate the normals.
    j = std::max(j, i);
    while (j + 1 < points.size() && (points[j] - points[i]).norm() < base_m &&
           (points[j + 1] - points[j]).norm() < gap_m)
      ++j;
    const Eigen::Vector2d along = points[j] - points[i];
    if (along.norm() < base_m) continue;
    const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
    normals += normal * normal.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(normals);
  return {solver.eigenvectors().col(0), solver.eigenvalues()[0] / std::max(1.0, solver.eigenvalues()[1])};
}

Eigen::Matrix3d covariance_of(const ScanToMapFit& fit, const ScanPrior& prior,
                              const std::optional<Eigen::Vector2d>& unseen) {
  Eigen::Matrix3d seen = fit.information;
  if (unseen) {
    Eigen::Matrix3d without = Eigen::Matrix3d::Identity();
    without.topLeftCorner<2, 2>() -= *unseen * unseen->transpose();
    seen = without * seen * without;
  }
  const Eigen::Matrix3d information = seen + prior.information + 1e-3 * Eigen::Matrix3d::Identity();
  return std::max(0.01, fit.residual_variance) * information.inverse();
}

/// Keeps the guess along that direction, by `weight`: the map's gradient there is only noise of its cells, which would
/// keep the robot from moving (Zhang et al. 2016).
void keep_guess_along(const Eigen::Vector2d& direction, double weight, const ScanGuess& guess, FollowedScan& followed) {
  const Eigen::Vector2d position = followed.local_from_body.translation();
  const double off = direction.dot(guess.local_from_body.translation() - position);
  followed.local_from_body = SE2(followed.local_from_body.rotation(), position + weight * off * direction);
}

}  // namespace

FollowedScan ScanFollower::follow(Submap& map, std::span<const Eigen::Vector2d> points, const ScanGuess& guess) const {
  const SE2 submap_from_local = map.local_from_submap().inverse();
  SE2 start = submap_from_local * guess.local_from_body;
  const ScanPrior prior = prior_of(guess, start);
  const ScanToMapOptions matching{options_.match_iterations};
  FollowedScan followed;
  auto fit = match_scan_to_map(map.levels(), points, start, &prior, matching);
  const bool far = guess.sigma_m > options_.search_from_m || guess.sigma_rad > options_.search_from_rad;
  if (far || !fit || fit->score < options_.min_score) {
    followed.searched = true;
    // The surroundings may be mostly unmapped: the better of the two fits decides, not this.
    constexpr double least_score = 0.2;
    constexpr double sigmas = 4.0;
    const bool poor = !fit || fit->score < options_.min_score;
    const CorrelativeWindow window{
        poor ? options_.search_reach_m : std::min(options_.search_reach_m, sigmas * guess.sigma_m),
        poor ? options_.search_reach_rad : std::min(options_.search_reach_rad, sigmas * guess.sigma_rad), least_score};
    if (const auto found = map.correlative().search(points, start, window)) {
      const auto other = match_scan_to_map(map.levels(), points, found->map_from_body, nullptr, matching);
      if (other && (!fit || other->score > fit->score)) fit = other;
    }
  }
  followed.local_from_body = guess.local_from_body;
  if (!fit) return followed;
  followed.score = fit->score;
  followed.fits = fit->score >= options_.min_score;
  if (!followed.fits) return followed;
  followed.local_from_body = map.local_from_submap() * fit->map_from_body;
  const WeakDirection weak = weak_direction(points);
  const Eigen::Vector2d direction = followed.local_from_body.rotation() * weak.direction;
  if (weak.share < options_.degenerate_ratio) followed.unseen_direction = direction;
  // The scan's influence along the direction grows from none at that share to full at three times that share.
  const double weight = std::clamp(1.5 - 0.5 * weak.share / options_.degenerate_ratio, 0.0, 1.0);
  followed.sees_all_directions = weight == 0.0;
  if (guess.trusted && weight > 0.0) keep_guess_along(direction, weight, guess, followed);
  followed.covariance = covariance_of(*fit, prior, followed.unseen_direction);
  return followed;
}

}  // namespace rastro
