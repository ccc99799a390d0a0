// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/submap_graph.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "rastro/backend/acceptance.h"
#include "rastro/map/graph/planar.h"
#include "rastro/optimize/pose_graph.h"
#include "rastro/registration/scan_to_map.h"

namespace rastro {
namespace {

/// Added to the match covariance of a scan in its own submap: cell size and beam errors.
constexpr double least_sigma_m = 0.02, least_sigma_rad = 0.005;
/// Upper bound of the error, however uninformative a match is.
constexpr double largest_sigma_m = 3.0, largest_sigma_rad = 0.3;

/// An edge between two poses of the graph; `information` is of (x, y, yaw) in the frame of `from`.
Constraint edge_between(std::size_t from, std::size_t to, const SE2& from_from_to, const Eigen::Matrix3d& information,
                        ConstraintKind kind) {
  return planar_constraint(static_cast<KeyframeId>(from), static_cast<KeyframeId>(to), from_from_to, information, kind);
}

Eigen::Matrix3d information_of(const Eigen::Matrix3d& covariance, double sigma_m, double sigma_rad) {
  Eigen::Matrix3d sum = covariance;
  sum.diagonal() += Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad);
  Eigen::Matrix3d information = sum.inverse();
  constexpr double position_information = 1.0 / (largest_sigma_m * largest_sigma_m);
  information.diagonal() +=
      Eigen::Vector3d(position_information, position_information, 1.0 / (largest_sigma_rad * largest_sigma_rad));
  return information;
}

/// The search evaluates very many poses; a subset of the points is nearly as informative as all.
std::vector<Eigen::Vector2d> thinned(const std::vector<Eigen::Vector2d>& points) {
  constexpr std::size_t most = 200;
  const std::size_t every = (points.size() + most - 1) / most;
  std::vector<Eigen::Vector2d> kept;
  for (std::size_t i = 0; i < points.size(); i += every) kept.push_back(points[i]);
  return kept;
}

}  // namespace

std::size_t SubmapGraph::add_submap(const SE2& local_from_body) {
  const SE2 world_from_local_now = world_from_local();
  submaps_.push_back(std::make_unique<Submap>(options_, local_from_body));
  pose_of_submap_.push_back(poses_.size());
  poses_.push_back(world_from_local_now * submaps_.back()->local_from_submap());
  return submaps_.size() - 1;
}

std::size_t SubmapGraph::add_key_scan(KeyScan scan, const Eigen::Matrix3d& covariance) {
  const std::size_t key_scan = key_scans_.size();
  const SE2 world_from_body = world_from_local() * scan.local_from_body;
  for (std::size_t s = 0; s < submaps_.size(); ++s) {
    if (!submaps_[s]->finished()) submaps_[s]->insert(scan.scan, scan.local_from_body, key_scan);
  }
  if (!scan.gap_covariance.isZero(0.0)) after_gaps_.push_back(key_scan);
  key_scans_.push_back(std::move(scan));
  pose_of_key_scan_.push_back(poses_.size());
  poses_.push_back(world_from_body);
  for (std::size_t s = 0; s < submaps_.size(); ++s) {
    if (!submaps_[s]->finished()) constrain_to_submap(s, key_scan, covariance);
  }
  if (key_scan > 0) constrain_to_last(key_scan);
  return key_scan;
}

SE2 SubmapGraph::world_from_local() const {
  if (key_scans_.empty()) return SE2();
  return poses_[pose_of_key_scan_.back()] * key_scans_.back().local_from_body.inverse();
}

void SubmapGraph::constrain_to_submap(std::size_t submap, std::size_t key_scan, const Eigen::Matrix3d& covariance) {
  const SE2 submap_from_body = submaps_[submap]->local_from_submap().inverse() * key_scans_[key_scan].local_from_body;
  constraints_.push_back(edge_between(pose_of_submap_[submap], pose_of_key_scan_[key_scan], submap_from_body,
                                      information_of(covariance, least_sigma_m, least_sigma_rad),
                                      ConstraintKind::odometry));
}

/// Constrains consecutive key scans by the matcher's relative pose (along an unobservable direction that of odometry,
/// with a larger variance). This constraint is never rejected.
void SubmapGraph::constrain_to_last(std::size_t key_scan) {
  const KeyScan &last = key_scans_[key_scan - 1], &scan = key_scans_[key_scan];
  const SE2 last_from_body = last.local_from_body.inverse() * scan.local_from_body;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (last.unseen_direction) {
    constexpr double slip_share = 0.3;
    const Eigen::Vector2d along = slip_share * last_from_body.translation().norm() * *last.unseen_direction;
    covariance.topLeftCorner<2, 2>() = along * along.transpose();
  }
  Eigen::Matrix3d last_from_local = Eigen::Matrix3d::Identity();
  last_from_local.topLeftCorner<2, 2>() = last.local_from_body.rotation().inverse().matrix();
  covariance += last_from_local * scan.gap_covariance * last_from_local.transpose();
  constraints_.push_back(edge_between(pose_of_key_scan_[key_scan - 1], pose_of_key_scan_[key_scan], last_from_body,
                                      information_of(covariance, least_sigma_m, least_sigma_rad),
                                      ConstraintKind::odometry));
}

bool SubmapGraph::made_by(std::size_t submap, std::size_t key_scan) const {
  const std::vector<std::size_t>& scans = submaps_[submap]->key_scans();
  return !scans.empty() && key_scan >= scans.front() && key_scan <= scans.back();
}

/// Distance to the nearest sensor position of the submap's scans.
double SubmapGraph::distance_to(std::size_t submap, const Eigen::Vector2d& world) const {
  double nearest = 1e9;
  for (const std::size_t k : submaps_[submap]->key_scans())
    nearest = std::min(nearest, (world_from_key_scan(k).translation() - world).norm());
  return nearest;
}

std::vector<Constraint> SubmapGraph::constraints() const {
  std::map<KeyframeId, KeyframeId> key_scan_of;  // by pose
  for (std::size_t k = 0; k < pose_of_key_scan_.size(); ++k)
    key_scan_of[static_cast<KeyframeId>(pose_of_key_scan_[k])] = static_cast<KeyframeId>(k);
  std::vector<Constraint> constraints;
  for (Constraint edge : constraints_) {
    const auto from = key_scan_of.find(edge.from), to = key_scan_of.find(edge.to);
    if (from == key_scan_of.end() || to == key_scan_of.end()) continue;
    edge.from = from->second;
    edge.to = to->second;
    constraints.push_back(edge);
  }
  for (const ClosedLoop& loop : loops_) {
    const std::size_t first = key_scans_of(loop.submap).front();
    const SE2 first_from_submap = world_from_key_scan(first).inverse() * world_from_submap(loop.submap);
    Constraint edge = edge_of(loop);  // its information is in the axes of its end, which stays the same
    edge.from = static_cast<KeyframeId>(first);
    edge.to = static_cast<KeyframeId>(loop.key_scan);
    edge.from_from_to = Sim3(in_space(first_from_submap * loop.submap_from_body));
    constraints.push_back(edge);
  }
  return constraints;
}

/// The last key scan with a constraint to the submap or an older one, by submap: what comes after it may have drifted.
std::vector<std::size_t> SubmapGraph::last_constrained() const {
  std::vector<std::size_t> last(submaps_.size(), 0);
  for (const ClosedLoop& loop : loops_) last[loop.submap] = std::max(last[loop.submap], loop.key_scan);
  std::size_t older = 0;
  for (std::size_t s = 0; s < submaps_.size(); ++s) {
    older = std::max(older, last[s]);
    const std::size_t made = submaps_[s]->key_scans().empty() ? 0 : submaps_[s]->key_scans().back();
    last[s] = std::max(made, older);
  }
  return last;
}

/// Of key scan `to` relative to `from`, by the missing scans between them alone: meters and radians.
Eigen::Vector2d SubmapGraph::gap_sigma(std::size_t from, std::size_t to) const {
  Eigen::Vector2d variance = Eigen::Vector2d::Zero();
  for (const std::size_t gap : after_gaps_) {
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

std::vector<SubmapGraph::Candidate> SubmapGraph::candidates_of(std::size_t key_scan, bool near_only) const {
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
    const double distance = distance_to(s, world_from_key_scan(key_scan).translation());
    if (distance < options_.loop_near_m + candidate.reach_m) candidates.push_back(candidate);
  }
  return candidates;
}

/// Points of the key scan and those before it, in its body frame, one per cell: several scans are less ambiguous than
/// one. None from before missing scans: they would fit where they were, and hold the others there.
std::vector<Eigen::Vector2d> SubmapGraph::points_around(std::size_t key_scan) const {
  std::size_t first = key_scan + 1 - std::min(key_scan + 1, static_cast<std::size_t>(options_.loop_scans));
  for (const std::size_t gap : after_gaps_)
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

std::optional<ClosedLoop> SubmapGraph::verify(const Candidate& candidate) const {
  Submap& submap = *submaps_[candidate.submap];
  const std::vector<Eigen::Vector2d> points = points_around(candidate.key_scan);
  const SE2 expected = world_from_submap(candidate.submap).inverse() * world_from_key_scan(candidate.key_scan);
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
  if (const auto& unseen = key_scans_[candidate.key_scan].unseen_direction) {
    // Only the noise of the cells constrains this direction.
    const Eigen::Vector2d along = largest_sigma_m * (fit->map_from_body.rotation() * *unseen);
    loop.covariance.topLeftCorner<2, 2>() += along * along.transpose();
  }
  return loop;
}

SE2 SubmapGraph::correction_by(const ClosedLoop& loop) const {
  return world_from_submap(loop.submap) * loop.submap_from_body * world_from_key_scan(loop.key_scan).inverse();
}

/// Loops that move the map only little, or agree with the loop of another key scan.
std::vector<ClosedLoop> SubmapGraph::accepted(const std::vector<std::optional<ClosedLoop>>& verified) const {
  std::vector<ClosedLoop> loops;
  std::vector<MapCorrection> corrections;
  for (const auto& loop : verified) {
    if (!loop) continue;
    loops.push_back(*loop);
    corrections.push_back({static_cast<std::int64_t>(loop->key_scan), in_space(correction_by(*loop)),
                           in_space(world_from_key_scan(loop->key_scan)).translation()});
  }
  const auto agreed = agreeing(corrections, {options_.loop_agreement_m, options_.loop_agreement_rad});
  std::vector<ClosedLoop> kept;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (agreed[i] != 0) kept.push_back(loops[i]);
  }
  return kept;
}

int SubmapGraph::close(const std::vector<Candidate>& candidates) {
  prepare_search(candidates);
  int closed = 0;
  for (const ClosedLoop& loop : accepted(verified(candidates))) {
    std::erase_if(loops_,
                  [&](const ClosedLoop& old) { return old.submap == loop.submap && old.key_scan == loop.key_scan; });
    loops_.push_back(loop);
    ++closed;
  }
  if (sparing_)
    for (const auto& submap : submaps_) submap->forget_correlative();
  return closed;
}

/// Prepares what the threads then only read.
void SubmapGraph::prepare_search(const std::vector<Candidate>& candidates) {
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

std::vector<std::optional<ClosedLoop>> SubmapGraph::verified(const std::vector<Candidate>& candidates) const {
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

int SubmapGraph::search_loops(std::size_t first) {
  std::vector<Candidate> candidates;
  const auto every = static_cast<std::size_t>(options_.loop_every);
  for (std::size_t k = (first + every - 1) / every * every; k < key_scans_.size(); k += every) {
    for (const Candidate& candidate : candidates_of(k, false)) candidates.push_back(candidate);
  }
  return close(candidates);
}

int SubmapGraph::constrain_neighbors() {
  std::vector<Candidate> candidates;
  const auto every = static_cast<std::size_t>(options_.constrain_every);
  for (std::size_t k = 0; k < key_scans_.size(); k += every) {
    for (const Candidate& candidate : candidates_of(k, true)) candidates.push_back(candidate);
  }
  return close(candidates);
}

Constraint SubmapGraph::edge_of(const ClosedLoop& loop) const {
  return edge_between(pose_of_submap_[loop.submap], pose_of_key_scan_[loop.key_scan], loop.submap_from_body,
                      information_of(loop.covariance, options_.loop_sigma_m, options_.loop_sigma_rad),
                      ConstraintKind::loop);
}

std::vector<Constraint> SubmapGraph::edges() const {
  std::vector<Constraint> edges = constraints_;
  for (const ClosedLoop& loop : loops_) edges.push_back(edge_of(loop));
  return edges;
}

void SubmapGraph::optimize() {
  fit_poses();
  const std::size_t before = loops_.size();
  std::erase_if(loops_, [&](const ClosedLoop& loop) { return contradicted(loop); });
  if (loops_.size() < before) fit_poses();
}

/// The first submap stays fixed.
void SubmapGraph::fit_poses() {
  std::vector<Constraint> edges = this->edges();
  std::vector<std::uint8_t> fixed(poses_.size(), 0);
  if (!fixed.empty()) fixed.front() = 1;
  PoseGraphOptions options;
  options.loops = LoopModel::robust;
  options.robust_width = options_.robust_width;
  options.iterations = 50;
  optimize_pose_graph(poses_, edges, fixed, options);
}

/// Whether the rest of the graph contradicts the loop.
bool SubmapGraph::contradicted(const ClosedLoop& loop) const {
  const double squared =
      squared_sigmas(edge_of(loop), world_from_submap(loop.submap), world_from_key_scan(loop.key_scan));
  return judge({.graph_sigmas = std::sqrt(squared)}, {.max_graph_sigmas = options_.loop_reject_sigmas}) !=
         Rejection::none;
}

}  // namespace rastro
