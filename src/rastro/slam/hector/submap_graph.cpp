// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/submap_graph.h"

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <utility>

#include "rastro/backend/acceptance.h"
#include "rastro/map/graph/planar.h"
#include "rastro/optimize/pose_graph.h"
#include "rastro/slam/hector/loop_search.h"

namespace rastro {
namespace {

/// Added to the match covariance of a scan in its own submap: cell size and beam errors.
constexpr double least_sigma_m = 0.02, least_sigma_rad = 0.005;
/// Upper bound of the error, however uninformative a match is.
constexpr double largest_sigma_m = SubmapGraph::largest_sigma_m, largest_sigma_rad = 0.3;

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

int SubmapGraph::search_loops(std::size_t first) { return close(LoopSearch(*this, options_, pool_).from(first)); }

int SubmapGraph::constrain_neighbors() { return close(LoopSearch(*this, options_, pool_).of_neighbors()); }

int SubmapGraph::close(const std::vector<ClosedLoop>& loops) {
  for (const ClosedLoop& loop : loops) {
    std::erase_if(loops_,
                  [&](const ClosedLoop& old) { return old.submap == loop.submap && old.key_scan == loop.key_scan; });
    loops_.push_back(loop);
  }
  if (sparing_)
    for (const auto& submap : submaps_) submap->forget_correlative();
  return static_cast<int>(loops.size());
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
