// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/scan_follower.h"

#include <Eigen/LU>
#include <algorithm>
#include <numbers>

#include "rastro/slam/hector/weak_direction.h"

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

/// What match_scan_to_map() minimizes, in total.
double cost_of(const ScanToMapFit& fit, std::size_t points, const ScanPrior& prior) {
  const SE2 off = prior.pose.inverse() * fit.map_from_body;
  const Eigen::Vector3d error(off.translation().x(), off.translation().y(), off.rotation().angle());
  return static_cast<double>(points) * fit.residual_variance + error.dot(prior.information * error);
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

/// The share of the guess along the direction, none at three times `ratio` and all below it.
double weight_of_guess(double share, double ratio) { return std::clamp(1.5 - 0.5 * share / ratio, 0.0, 1.0); }

/// Keeps the guess along that direction, by `weight`: the map's gradient there is only noise of its cells, which would
/// keep the robot from moving (Zhang et al. 2016).
void keep_guess_along(const Eigen::Vector2d& direction, double weight, const ScanGuess& guess, FollowedScan& followed) {
  const Eigen::Vector2d position = followed.local_from_body.translation();
  const double off = direction.dot(guess.local_from_body.translation() - position);
  followed.local_from_body = SE2(followed.local_from_body.rotation(), position + weight * off * direction);
  if (followed.unseen_direction) return;  // the covariance leaves it to the guess
  // The variance of a mixture: right is the guess, with its sigma, or the scan.
  const double variance = weight * guess.sigma_m * guess.sigma_m + weight * (1.0 - weight) * off * off;
  followed.guess_covariance.topLeftCorner<2, 2>() = variance * direction * direction.transpose();
}

}  // namespace

/// Unknown cells count a half, more than a poor match: where most of the scan lies in them, the rest must agree alone.
bool ScanFollower::contradicted(const ScanToMapFit& fit, std::size_t points) const {
  if (fit.score < options_.min_score) return true;
  const bool mostly_unknown = 2 * static_cast<std::size_t>(fit.mapped) < points;
  return mostly_unknown && !unmapped(fit) && fit.agreement < options_.min_score;
}

/// Around a guess that the map contradicts, all that its sigma allows: without odometry the motion may have ended.
CorrelativeWindow ScanFollower::window(const ScanGuess& guess, bool doubtful) const {
  // The surroundings may be mostly unmapped: the better of the two fits decides, not the least score.
  constexpr double sigmas = 4.0, farthest = 2.5, least_score = 0.2;
  const double within_m = sigmas * guess.sigma_m, within_rad = sigmas * guess.sigma_rad;
  // After a gap a match may be a poor one, as what comes is mapped apart: no place is searched for.
  if (doubtful && guess.after_gap) return {options_.search_reach_m, options_.search_reach_rad, least_score};
  if (doubtful) {
    return {std::clamp(within_m, options_.search_reach_m, farthest * options_.search_reach_m),
            std::max(options_.search_reach_rad, std::min(within_rad, std::numbers::pi)), least_score};
  }
  return {std::min(options_.search_reach_m, within_m), std::min(options_.search_reach_rad, within_rad), least_score};
}

/// Best match in the window around the guess; nullopt where the map tells nothing of it.
std::optional<ScanToMapFit> ScanFollower::searched(Submap& map, std::span<const Eigen::Vector2d> points,
                                                   const ScanGuess& guess, bool doubtful) const {
  const auto found = map.correlative().search(points, map.local_from_submap().inverse() * guess.local_from_body,
                                              window(guess, doubtful));
  if (!found) return std::nullopt;
  const auto fit = match_scan_to_map(map.levels(), points, found->map_from_body, nullptr, {options_.match_iterations});
  return fit && !unmapped(*fit) ? fit : std::nullopt;
}

void ScanFollower::keep_guess_where_unseen(std::span<const Eigen::Vector2d> points, const ScanGuess& guess,
                                           FollowedScan& followed) const {
  const WeakDirection weak = weak_direction(points);
  const Eigen::Vector2d direction = followed.local_from_body.rotation() * weak.direction;
  if (weak.share < options_.degenerate_ratio) followed.unseen_direction = direction;
  const double weight = weight_of_guess(weak.share, options_.degenerate_ratio);
  followed.sees_all_directions = weight == 0.0 && !followed.unmapped;
  if (guess.trusted && weight > 0.0) keep_guess_along(direction, weight, guess, followed);
}

FollowedScan ScanFollower::follow(Submap& map, std::span<const Eigen::Vector2d> points, const ScanGuess& guess) const {
  const SE2 start = map.local_from_submap().inverse() * guess.local_from_body;
  const ScanPrior prior = prior_of(guess, start);
  FollowedScan followed;
  followed.local_from_body = guess.local_from_body;
  auto fit = match_scan_to_map(map.levels(), points, start, &prior, {options_.match_iterations});
  const bool poor = !fit || contradicted(*fit, points.size());
  // Where scan and map hardly tell two poses apart, the one that the motion so far expects is right.
  const auto better = [&](const ScanToMapFit& a, const ScanToMapFit& b) {
    return cost_of(a, points.size(), prior) < cost_of(b, points.size(), prior);
  };
  // Far from what was expected much fits a little.
  const bool doubtful = poor || guess.after_loss;
  followed.searched = doubtful || guess.sigma_m > options_.search_from_m || guess.sigma_rad > options_.search_from_rad;
  if (followed.searched) {
    const auto other = searched(map, points, guess, doubtful);
    if (other && (!fit || (doubtful ? other->score > fit->score : better(*other, *fit)))) fit = other;
  }
  if (!fit) return followed;
  followed.score = fit->score;
  followed.mapped = fit->mapped;
  const bool must_be_clear = doubtful && !guess.after_gap && !unmapped(*fit);
  followed.needs = must_be_clear ? options_.loop_min_score : options_.min_score;
  followed.fits = !contradicted(*fit, points.size()) && (!must_be_clear || clear(*fit));
  if (!followed.fits) return followed;
  followed.unmapped = unmapped(*fit);
  if (followed.unmapped) {
    fit->information.setZero();
  } else {
    followed.local_from_body = map.local_from_submap() * fit->map_from_body;
  }
  keep_guess_where_unseen(structure_of(map, points, fit->map_from_body), guess, followed);
  followed.covariance = covariance_of(*fit, prior, followed.unseen_direction);
  return followed;
}

}  // namespace rastro
