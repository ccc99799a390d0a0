// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/scan_follower.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

#include "rastro/registration/scan_to_map.h"

namespace rastro {
namespace {

/// Of 1 - M about a good pose: what a sigma of the guess weighs against the beams.
constexpr double usual_variance = 0.1;

ScanPrior prior_of(const ScanGuess& guess, const SE2& submap_from_body) {
  ScanPrior prior;
  prior.pose = submap_from_body;
  if (!guess.trusted) return prior;
  const double place = usual_variance / (guess.sigma_m * guess.sigma_m);
  const double turn = usual_variance / (guess.sigma_rad * guess.sigma_rad);
  prior.information.diagonal() << place, place, turn;
  return prior;
}

std::optional<Eigen::Vector2d> unseen_direction(const Eigen::Matrix3d& information, double ratio) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(information.topLeftCorner<2, 2>());
  const Eigen::Vector2d values = solver.eigenvalues();
  if (values[0] >= ratio * values[1]) return std::nullopt;
  return Eigen::Vector2d(solver.eigenvectors().col(0));
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
    const CorrelativeWindow window{options_.search_reach_m, options_.search_reach_rad,
                                   std::max(options_.min_score, fit ? fit->score : 0.0)};
    if (const auto found = map.correlative().search(points, start, window))
      fit = match_scan_to_map(map.levels(), points, found->map_from_body, nullptr, matching);
  }
  followed.local_from_body = guess.local_from_body;
  if (!fit) return followed;
  followed.score = fit->score;
  followed.fits = fit->score >= options_.min_score;
  if (!followed.fits) return followed;
  followed.local_from_body = map.local_from_submap() * fit->map_from_body;
  const Eigen::Matrix3d information = fit->information + prior.information + 1e-3 * Eigen::Matrix3d::Identity();
  followed.covariance = std::max(0.01, fit->residual_variance) * information.inverse();
  followed.unseen_direction = unseen_direction(fit->information, options_.degenerate_ratio);
  return followed;
}

}  // namespace rastro
