// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/loop_search.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "rastro/backend/acceptance.h"
#include "rastro/map/graph/planar.h"
#include "rastro/registration/scan_to_map.h"
#include "rastro/slam/hector/weak_direction.h"

namespace rastro {
namespace {

/// The search evaluates very many poses; a subset of the points is nearly as informative as all.
std::vector<Eigen::Vector2d> thinned(const std::vector<Eigen::Vector2d>& points) {
  constexpr std::size_t most = 200;
  const std::size_t every = (points.size() + most - 1) / most;
  std::vector<Eigen::Vector2d> kept;
  for (std::size_t i = 0; i < points.size(); i += every) kept.push_back(points[i]);
  return kept;
}

}  // namespace

std::vector<ClosedLoop> LoopSearch::from(std::size_t first) const {
  std::vector<Candidate> candidates;
  const auto every = static_cast<std::size_t>(options_.loop_every);
  for (std::size_t k = (first + every - 1) / every * every; k < key_scans_.size(); k += every) {
    for (const Candidate& candidate : candidates_of(k, false)) candidates.push_back(candidate);
  }
  return found_in(candidates);
}

std::vector<ClosedLoop> LoopSearch::of_neighbors() const {
  std::vector<Candidate> candidates;
  const auto every = static_cast<std::size_t>(options_.constrain_every);
  for (std::size_t k = 0; k < key_scans_.size(); k += every) {
    for (const Candidate& candidate : candidates_of(k, true)) candidates.push_back(candidate);
  }
  return found_in(candidates);
}

std::vector<ClosedLoop> LoopSearch::found_in(const std::vector<Candidate>& candidates) const {
  prepare_search(candidates);
  return accepted(verified(candidates));
}

bool LoopSearch::made_by(std::size_t submap, std::size_t key_scan) const {
  const std::vector<std::size_t>& scans = submaps_[submap]->key_scans();
  return !scans.empty() && key_scan >= scans.front() && key_scan <= scans.back();
}

/// Distance to the nearest sensor position of the submap's scans.
double LoopSearch::distance_to(std::size_t submap, const Eigen::Vector2d& world) const {
  double nearest = 1e9;
  for (const std::size_t k : submaps_[submap]->key_scans())
    nearest = std::min(nearest, (graph_.world_from_key_scan(k).translation() - world).norm());
  return nearest;
}

/// The last key scan with a constraint to the submap or an older one, by submap: what comes after it may have drifted.
std::vector<std::size_t> LoopSearch::last_constrained() const {
  std::vector<std::size_t> last(submaps_.size(), 0);
  for (const ClosedLoop& loop : graph_.loops()) last[loop.submap] = std::max(last[loop.submap], loop.key_scan);
  std::size_t older = 0;
  for (std::size_t s = 0; s < submaps_.size(); ++s) {
    older = std::max(older, last[s]);
    const std::size_t made = submaps_[s]->key_scans().empty() ? 0 : submaps_[s]->key_scans().back();
    last[s] = std::max(made, older);
  }
  return last;
}

/// Of key scan `to` relative to `from`, by the missing scans between them alone: meters and radians.
Eigen::Vector2d LoopSearch::gap_sigma(std::size_t from, std::size_t to) const {
  Eigen::Vector2d variance = Eigen::Vector2d::Zero();
  for (const std::size_t gap : graph_.after_gaps()) {
    if (gap <= from || gap > to) continue;
    const Eigen::Matrix3d& covariance = key_scans_[gap].gap_covariance;
    const Eigen::Matrix2d position = covariance.topLeftCorner<2, 2>();
    const Eigen::Vector2d since =
        key_scans_[to].local_from_body.translation() - key_scans_[gap].local_from_body.translation();
    variance.x() += position.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
    variance.x() += covariance(2, 2) * since.squaredNorm();  // a wrong heading leads away
    variance.y() += covariance(2, 2);
  }
  return variance.cwiseSqrt();
}

std::vector<LoopSearch::Candidate> LoopSearch::candidates_of(std::size_t key_scan, bool near_only) const {
  std::vector<Candidate> candidates;
  const std::vector<std::size_t> last_constrained = this->last_constrained();
  for (std::size_t s = 0; s < submaps_.size(); ++s) {
    const std::vector<std::size_t>& scans = submaps_[s]->key_scans();  // none if missing scans followed its beginning
    if (!submaps_[s]->finished() || submaps_[s]->released() || scans.empty() || made_by(s, key_scan)) continue;
    if (!near_only && key_scan < scans.back()) continue;
    Candidate candidate{s, key_scan, 0.0, 0.0, !near_only};
    if (!near_only) {
      constexpr double gap_sigmas = 3.0;
      const std::size_t last = last_constrained[s];
      const double path_m = std::max(0.0, key_scans_[key_scan].path_m - key_scans_[last].path_m);
      const Eigen::Vector2d gap = gap_sigmas * gap_sigma(last, key_scan);
      candidate.reach_m =
          std::min(options_.loop_max_reach_m, options_.loop_reach_m + options_.loop_drift_share * path_m + gap.x());
      candidate.reach_rad = std::min(options_.loop_max_reach_rad,
                                     options_.loop_reach_rad + options_.loop_drift_rad_per_m * path_m + gap.y());
    }
    const double distance = distance_to(s, graph_.world_from_key_scan(key_scan).translation());
    if (distance < options_.loop_near_m + candidate.reach_m) candidates.push_back(candidate);
  }
  return candidates;
}

/// Points of the key scan and those before it, in its body frame, one per cell: several scans are less ambiguous than
/// one. None from before missing scans: they would fit where they were, and hold the others there.
std::vector<Eigen::Vector2d> LoopSearch::points_around(std::size_t key_scan) const {
  std::size_t first = key_scan + 1 - std::min(key_scan + 1, static_cast<std::size_t>(options_.loop_scans));
  for (const std::size_t gap : graph_.after_gaps())
    if (gap <= key_scan) first = std::max(first, gap);
  const SE2 body_from_local = key_scans_[key_scan].local_from_body.inverse();
  std::set<std::pair<int, int>> taken;
  std::vector<Eigen::Vector2d> points;
  for (std::size_t k = first; k <= key_scan; ++k) {
    const SE2 body_from_other = body_from_local * key_scans_[k].local_from_body;
    for (const Eigen::Vector2d& point : key_scans_[k].scan.points) {
      const Eigen::Vector2d here = body_from_other * point;
      const Eigen::Vector2d cell = (here / options_.cell_m).array().floor();
      if (taken.insert({static_cast<int>(cell.x()), static_cast<int>(cell.y())}).second) points.push_back(here);
    }
  }
  return points;
}

/// Body frame. What comes into view at the end of a corridor is in no submap of it, though the scan sees all
/// directions, and a search finds it a place. Beside the pose of the graph there is none to be mistaken for, and
/// without odometry nothing else tells the way along: a doubtful place is better than none there (intel: 0.06 instead
/// of 0.24 m).
std::optional<Eigen::Vector2d> LoopSearch::unseen_direction(const Candidate& candidate,
                                                            const SE2& submap_from_body) const {
  const KeyScan& key_scan = key_scans_[candidate.key_scan];
  if (key_scan.unseen_direction || key_scan.assumed_motion || !candidate.search) return key_scan.unseen_direction;
  const auto structure = structure_of(*submaps_[candidate.submap], key_scan.scan.points, submap_from_body);
  const WeakDirection weak = weak_direction(structure);
  return weak.share < options_.degenerate_ratio ? std::optional(weak.direction) : std::nullopt;
}

std::optional<ClosedLoop> LoopSearch::verify(const Candidate& candidate) const {
  Submap& submap = *submaps_[candidate.submap];
  const std::vector<Eigen::Vector2d> points = points_around(candidate.key_scan);
  const SE2 expected =
      graph_.world_from_submap(candidate.submap).inverse() * graph_.world_from_key_scan(candidate.key_scan);
  SE2 start = expected;
  if (candidate.search) {
    const CorrelativeWindow window{candidate.reach_m, candidate.reach_rad, 0.85 * options_.loop_min_score};
    const auto found = submap.correlative().search(thinned(points), expected, window);
    if (!found) return std::nullopt;
    start = found->map_from_body;
  }
  const auto fit = match_scan_to_map(submap.levels(), points, start, nullptr, {options_.match_iterations});
  if (!fit || judge({.score = fit->score}, {.min_score = options_.loop_min_score}) != Rejection::none)
    return std::nullopt;
  ClosedLoop loop{candidate.submap, candidate.key_scan, fit->score, fit->map_from_body, Eigen::Matrix3d::Zero()};
  const Eigen::Matrix3d information = fit->information + 1e-3 * Eigen::Matrix3d::Identity();
  loop.covariance = std::max(0.01, fit->residual_variance) * information.inverse();
  if (const auto unseen = unseen_direction(candidate, fit->map_from_body)) {
    // Only the noise of the cells constrains this direction.
    const Eigen::Vector2d along = SubmapGraph::largest_sigma_m * (fit->map_from_body.rotation() * *unseen);
    loop.covariance.topLeftCorner<2, 2>() += along * along.transpose();
  }
  return loop;
}

SE2 LoopSearch::correction_by(const ClosedLoop& loop) const {
  return graph_.world_from_submap(loop.submap) * loop.submap_from_body *
         graph_.world_from_key_scan(loop.key_scan).inverse();
}

/// Loops that move the map only little, or agree with the loop of another key scan.
std::vector<ClosedLoop> LoopSearch::accepted(const std::vector<std::optional<ClosedLoop>>& verified) const {
  std::vector<ClosedLoop> loops;
  std::vector<MapCorrection> corrections;
  for (const auto& loop : verified) {
    if (!loop) continue;
    loops.push_back(*loop);
    corrections.push_back({static_cast<std::int64_t>(loop->key_scan), in_space(correction_by(*loop)),
                           in_space(graph_.world_from_key_scan(loop->key_scan)).translation()});
  }
  const auto agreed = agreeing(corrections, {options_.loop_agreement_m, options_.loop_agreement_rad});
  std::vector<ClosedLoop> kept;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (agreed[i] != 0) kept.push_back(loops[i]);
  }
  return kept;
}

/// Prepares what the threads then only read.
void LoopSearch::prepare_search(const std::vector<Candidate>& candidates) const {
  std::set<std::size_t> searched;
  for (const Candidate& candidate : candidates) {
    if (candidate.search) searched.insert(candidate.submap);
  }
  for (std::size_t s = 0; s < submaps_.size(); ++s) {
    if (searched.contains(s)) {
      submaps_[s]->correlative();
    } else {
      submaps_[s]->forget_correlative();
    }
  }
}

std::vector<std::optional<ClosedLoop>> LoopSearch::verified(const std::vector<Candidate>& candidates) const {
  std::vector<std::optional<ClosedLoop>> found(candidates.size());
  const auto verify_some = [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      found[i] = verify(candidates[i]);
  };
  const int count = static_cast<int>(candidates.size());
  if (pool_) {
    pool_->for_chunks(0, count, 1, verify_some);
  } else {
    verify_some(0, count);
  }
  return found;
}

}  // namespace rastro
