// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/keyframe_graph.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/backend/loop_candidates.h"
#include "rastro/backend/rgbd/edge_covariance.h"
#include "rastro/base/error.h"

namespace rastro {
namespace {

PoseGraphOptions graph_options(const RgbdSlamOptions& options) {
  PoseGraphOptions graph;
  graph.loops = options.loops == "robust" ? LoopModel::robust : LoopModel::switchable;
  graph.switch_price = options.switch_price;
  graph.robust_width = options.robust_width;
  graph.iterations = options.optimize_iterations;
  return graph;
}

constexpr int freedoms = 6;

/// A constraint far off is wrong, not noisy.
double squared_noise(const Constraint& edge, const SE3& world_from_from, const SE3& world_from_to) {
  constexpr double most_sigmas = 3.0;
  return std::min(squared_sigmas(edge, world_from_from, world_from_to), freedoms * most_sigmas * most_sigmas);
}

}  // namespace

KeyframeGraph::KeyframeGraph(const RgbdSlamOptions& options, std::int64_t frozen)
    : options_(options), frozen_(frozen) {}

void KeyframeGraph::add(std::shared_ptr<const ImageFeatures> keyframe, const KeyframePose& pose,
                        const Matrix6d& covariance) {
  RASTRO_CHECK(keyframe->id == size(), "keyframes are numbered as they come");
  keyframes_.push_back(std::move(keyframe));
  poses_.push_back(pose.world_from_camera);
  submaps_.push_back(pose.submap);
  first_of_submap_.emplace(pose.submap, size() - 1);
  covariances_.push_back(covariance);
  edges_of_.emplace_back();
}

void KeyframeGraph::add_edge(const Constraint& edge) {
  edges_of_[static_cast<std::size_t>(edge.from)].push_back(edges_.size());
  edges_of_[static_cast<std::size_t>(edge.to)].push_back(edges_.size());
  edges_.push_back(edge);
  const SE3 step = edge.rigid();
  const double sigma_m = std::sqrt(edge.information.inverse().diagonal().head<3>().maxCoeff());
  const bool uncertain = sigma_m > uncertain_edge_m;
  // As long as a path on which tracking drifts as far.
  const double as_path_m = uncertain ? sigma_m / options_.loop_drift_share : 0.0;
  lengths_.push_back(step.translation().norm() + step.rotation().log().norm() + as_path_m);
  uncertain_.push_back(uncertain ? 1 : 0);
}

void KeyframeGraph::forget_features(std::int64_t id) {
  auto& entry = keyframes_[static_cast<std::size_t>(id)];
  entry = without_features(*entry);
}

void KeyframeGraph::restore_features(std::shared_ptr<const ImageFeatures> keyframe) {
  const auto index = static_cast<std::size_t>(keyframe->id);
  keyframes_[index] = std::move(keyframe);
}

std::shared_ptr<const ImageFeatures> without_features(const ImageFeatures& keyframe) {
  auto bare = std::make_shared<ImageFeatures>();
  bare->id = keyframe.id;
  bare->frame = keyframe.frame;
  bare->stamp = keyframe.stamp;
  bare->features.length = keyframe.features.length;
  return bare;
}

std::optional<std::int64_t> KeyframeGraph::most_redundant(int others) const {
  std::optional<std::int64_t> best;
  int most = others - 1;
  for (std::int64_t id = frozen_; id < size() - options_.graph_window; ++id) {
    if (keyframe(id).features.size() == 0) continue;
    std::vector<std::int64_t> neighbors;
    for (const std::size_t e : edges_of_[static_cast<std::size_t>(id)]) {
      const std::int64_t other = edges_[e].from == id ? edges_[e].to : edges_[e].from;
      if (keyframe(other).features.size() > 0 &&
          std::find(neighbors.begin(), neighbors.end(), other) == neighbors.end())
        neighbors.push_back(other);
    }
    if (static_cast<int>(neighbors.size()) <= most) continue;
    most = static_cast<int>(neighbors.size());
    best = id;
  }
  return best;
}

std::vector<KeyframePose> KeyframeGraph::keyframe_poses() const {
  std::vector<KeyframePose> result;
  result.reserve(poses_.size());
  for (std::size_t i = 0; i < poses_.size(); ++i) result.push_back({poses_[i], submaps_[i]});
  return result;
}

std::vector<std::int64_t> KeyframeGraph::neighborhood(std::int64_t id, int steps) const {
  return within_steps(id, steps, [this](std::int64_t node, const auto& visit) {
    for (const std::size_t e : edges_of_[static_cast<std::size_t>(node)])
      visit(edges_[e].from == node ? edges_[e].to : edges_[e].from);
  });
}

int KeyframeGraph::steps_between(std::int64_t from, std::int64_t to, int most) const {
  std::vector<std::int64_t> found{from};
  std::vector<std::uint8_t> seen(keyframes_.size(), 0);
  seen[static_cast<std::size_t>(from)] = 1;
  std::size_t next = 0;
  for (int step = 0; step < most; ++step) {
    for (const std::size_t end = found.size(); next < end; ++next) {
      if (found[next] == to) return step;
      for (const std::size_t e : edges_of_[static_cast<std::size_t>(found[next])]) {
        if (uncertain_[e] != 0) continue;
        const std::int64_t other = edges_[e].from == found[next] ? edges_[e].to : edges_[e].from;
        if (seen[static_cast<std::size_t>(other)] != 0) continue;
        seen[static_cast<std::size_t>(other)] = 1;
        found.push_back(other);
      }
    }
  }
  return most;
}

double KeyframeGraph::path_between(std::int64_t from, std::int64_t to) const {
  double path_m = 0.0;
  std::int64_t previous = from;
  for (std::int64_t id = from + 1; id <= to; ++id) {
    if (submap(id) != submap(from)) continue;
    const SE3 step = pose(previous).inverse() * pose(id);
    path_m += step.translation().norm() + step.rotation().log().norm();
    previous = id;
  }
  return path_m;
}

GraphPaths KeyframeGraph::graph_paths_from(std::int64_t from) const {
  return GraphPaths(from, [this](std::int64_t id) {
    std::vector<GraphPaths::Link> links;
    for (const std::size_t e : edges_of_[static_cast<std::size_t>(id)])
      links.push_back({edges_[e].from == id ? edges_[e].to : edges_[e].from, lengths_[e]});
    return links;
  });
}

std::optional<TrackedMotion> KeyframeGraph::tracked_motion(std::int64_t from, std::int64_t to, int most_steps) const {
  TrackedMotion motion;
  // Backward, as each keyframe has at most one odometry edge to an earlier one.
  for (int steps = 0; to != from; ++steps) {
    const auto& edges = edges_of_[static_cast<std::size_t>(to)];
    const auto tracked = std::find_if(edges.begin(), edges.end(), [&](std::size_t e) {
      return edges_[e].to == to && edges_[e].kind == ConstraintKind::odometry;
    });
    if (tracked == edges.end() || edges_[*tracked].from < from || steps == most_steps) return std::nullopt;
    const Constraint& edge = edges_[*tracked];
    const Matrix6d to_end = motion.from_from_to.inverse().adjoint();
    motion.covariance += to_end * edge.information.inverse() * to_end.transpose();
    motion.from_from_to = edge.rigid() * motion.from_from_to;
    to = edge.from;
  }
  return motion;
}

std::vector<std::int64_t> KeyframeGraph::candidates(std::int64_t id, Random& random) const {
  // In a given map, the previous frames say nothing about the pose in it.
  LoopCandidates candidates(frozen_ > 0 ? frozen_ : id);
  const auto to_match = [&](auto&& is_allowed) {
    return candidates.free([&](std::int64_t k) { return keyframe(k).features.size() > 0 && is_allowed(k); });
  };
  if (frozen_ == 0) candidates.add_latest(id, options_.last_candidates);
  // By position and viewing direction; the latest must not crowd out those of an earlier visit.
  std::vector<std::pair<double, std::int64_t>> latest, earlier;
  for (const std::int64_t other : to_match([&](std::int64_t k) { return submap(k) == submap(id); })) {
    if ((pose(other).translation() - pose(id).translation()).norm() > options_.near_distance_m) continue;
    const double distance =
        share_of_reach(pose(other).inverse() * pose(id), options_.near_distance_m, options_.near_angle_rad);
    const bool is_recent = other >= std::max(frozen_, id - options_.graph_window);
    if (distance < 1.0) (is_recent ? latest : earlier).emplace_back(distance, other);
  }
  candidates.add_nearest(std::move(latest), options_.near_candidates);
  candidates.add_nearest(std::move(earlier), options_.near_candidates);
  constexpr int reach = 3;
  candidates.add_random(neighborhood(id, reach), options_.graph_candidates, random);
  // Where none are asked for, the time must not grow with the map.
  if (options_.join_candidates > 0)
    candidates.add_random(to_match([&](std::int64_t k) { return submap(k) != submap(id); }), options_.join_candidates,
                          random);
  if (options_.random_candidates > 0)
    candidates.add_random(to_match([](std::int64_t) { return true; }), options_.random_candidates, random);
  return candidates.ids();
}

/// The submap of `joint`, an end of the edge, is as uncertain as the path to its first keyframe.
void KeyframeGraph::add_covariance_of_merge(const Constraint& edge, std::int64_t joint) {
  const Matrix6d of_path = covariance_over(edge, joint) + covariance(joint);
  for (std::int64_t k = 0; k < size(); ++k) {
    if (submap(k) != submap(joint)) continue;
    Matrix6d& sum = covariances_[static_cast<std::size_t>(k)];
    sum += moved_covariance(of_path, joint, k);
    sum = (0.5 * (sum + sum.transpose())).eval();
    merged_.insert(k);
  }
}

void KeyframeGraph::merge(const Constraint& edge) {
  const int a = submap(edge.from), b = submap(edge.to);
  if (a == b) return;
  const SE3 a_from_b = pose(edge.from) * edge.rigid() * pose(edge.to).inverse();
  const int kept = std::min(a, b), moved = std::max(a, b);
  const SE3 kept_from_moved = kept == a ? a_from_b : a_from_b.inverse();
  for (std::size_t k = 0; k < poses_.size(); ++k)
    if (submaps_[k] == moved) poses_[k] = kept_from_moved * poses_[k];
  add_covariance_of_merge(edge, kept == a ? edge.to : edge.from);
  std::replace(submaps_.begin(), submaps_.end(), moved, kept);
  std::int64_t& first = first_of_submap_.at(kept);
  first = std::min(first, first_of_submap_.at(moved));
  first_changed_ = std::min(first_changed_, first_of_submap_.at(moved));
  first_of_submap_.erase(moved);
}

/// Of the keyframes from `first` on, ascending.
std::vector<std::size_t> KeyframeGraph::edges_from(std::int64_t first) const {
  std::vector<std::size_t> edges;
  for (std::int64_t id = first; id < size(); ++id) {
    const auto& of_keyframe = edges_of_[static_cast<std::size_t>(id)];
    edges.insert(edges.end(), of_keyframe.begin(), of_keyframe.end());
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

bool KeyframeGraph::is_anchor(std::int64_t id) const { return frozen_ == 0 && first_of_submap_.at(submap(id)) == id; }

/// The keyframes from `first_free` on, and those that edges connect them to, which stay.
KeyframeGraph::Part KeyframeGraph::part_from(std::int64_t first_free) const {
  Part part;
  part.edge_numbers = edges_from(first_free);
  for (const std::size_t e : part.edge_numbers) {
    part.edges.push_back(edges_[e]);
    part.keyframes.insert(part.keyframes.end(), {edges_[e].from, edges_[e].to});
  }
  std::sort(part.keyframes.begin(), part.keyframes.end());
  part.keyframes.erase(std::unique(part.keyframes.begin(), part.keyframes.end()), part.keyframes.end());
  for (const std::int64_t id : part.keyframes) {
    part.poses.push_back(pose(id));
    part.fixed.push_back(id < first_free || is_anchor(id) ? 1 : 0);
  }
  const auto index_of = [&](std::int64_t id) {
    return std::lower_bound(part.keyframes.begin(), part.keyframes.end(), id) - part.keyframes.begin();
  };
  for (Constraint& edge : part.edges) edge.from = index_of(edge.from), edge.to = index_of(edge.to);
  return part;
}

/// From the residuals of an optimized part.
void KeyframeGraph::learn_noise(const Part& part) {
  const auto is_free = [&](std::int64_t k) { return part.fixed[static_cast<std::size_t>(k)] == 0; };
  double squared = 0.0;
  std::ptrdiff_t used = 0;
  for (const Constraint& edge : part.edges) {
    if (!is_free(edge.from) && !is_free(edge.to)) continue;
    squared += squared_noise(edge, part.poses[static_cast<std::size_t>(edge.from)],
                             part.poses[static_cast<std::size_t>(edge.to)]);
    ++used;
  }
  noise_.add(squared, freedoms * static_cast<double>(used - std::count(part.fixed.begin(), part.fixed.end(), 0)));
}

void KeyframeGraph::learn_noise() {
  double squared = 0.0;
  for (const Constraint& edge : edges_) squared += squared_noise(edge, pose(edge.from), pose(edge.to));
  noise_.add(squared, freedoms * (static_cast<double>(edges_.size()) - static_cast<double>(size())));
}

/// Loops since all keyframes were optimized, of which one is so far off that its switch would turn it off at once.
bool KeyframeGraph::a_new_loop_is_far_off() const {
  return std::any_of(edges_.begin() + static_cast<std::ptrdiff_t>(decided_edges_), edges_.end(),
                     [this](const Constraint& edge) {
                       const bool closes = edge.kind == ConstraintKind::loop || edge.kind == ConstraintKind::merge;
                       return closes && squared_sigmas(edge, pose(edge.from), pose(edge.to)) > options_.switch_price;
                     });
}

/// In a large graph the stages take up to a minute: there only a new loop that needs them gets them, and what was
/// decided about others stands.
PoseGraphResult KeyframeGraph::optimize(bool all) {
  PoseGraphOptions options = graph_options(options_);
  if (all) options.gradual = final_optimization(edges_.size(), options.iterations).gradual || a_new_loop_is_far_off();
  return optimize(all, options);
}

PoseGraphResult KeyframeGraph::optimize(bool all, const PoseGraphOptions& options) {
  const std::int64_t first_free = all ? frozen_ : std::max(frozen_, size() - options_.graph_window);
  Part part = part_from(first_free);
  const PoseGraphResult result = optimize_pose_graph(part.poses, part.edges, part.fixed, options);
  learn_noise(part);
  for (std::size_t i = 0; i < part.keyframes.size(); ++i)
    poses_[static_cast<std::size_t>(part.keyframes[i])] = part.poses[i];
  for (std::size_t i = 0; i < part.edges.size(); ++i) edges_[part.edge_numbers[i]].weight = part.edges[i].weight;
  first_changed_ = std::min(first_changed_, first_free);
  if (all) decided_edges_ = edges_.size();
  return result;
}

FinalOptimization final_optimization(std::size_t edges, int iterations) {
  constexpr double most_edge_iterations = 3e6;
  constexpr int most_rounds = 10, most_stages = 8;
  const double of_round = std::max(1.0, static_cast<double>(edges) * iterations);
  const int rounds = static_cast<int>(std::min(most_edge_iterations / of_round, 1.0 * (most_rounds + most_stages)));
  if (rounds > most_stages) return {true, std::min(most_rounds, rounds - most_stages)};
  return {false, std::max(1, rounds)};
}

/// Only at first are switches introduced gradually: what was decided there stands.
PoseGraphResult KeyframeGraph::optimize_until_converged() {
  constexpr double least_gain = 0.05;
  const FinalOptimization limits = final_optimization(edges_.size(), options_.optimize_iterations);
  PoseGraphOptions options = graph_options(options_);
  options.gradual = limits.gradual;
  PoseGraphResult result = optimize(true, options);
  const double first_cost = result.first_cost;
  options.gradual = false;
  for (int round = 1; round < limits.rounds && !result.converged; ++round) {
    result = optimize(true, options);
    if (result.last_cost > (1.0 - least_gain) * result.first_cost) break;
  }
  result.first_cost = first_cost;
  return result;
}

GraphChanges KeyframeGraph::take_changes() {
  GraphChanges changes{first_changed_, {}, {}, {}};
  for (std::int64_t id = first_changed_; id < size(); ++id) changes.poses.push_back({pose(id), submap(id)});
  for (const std::size_t e : edges_from(first_changed_)) changes.weights.push_back({e, edges_[e].weight});
  for (const std::int64_t id : merged_) changes.covariances.emplace_back(id, covariance(id));
  first_changed_ = size();
  merged_.clear();
  return changes;
}

/// From what is known of the keyframe at the other end of the edge.
Matrix6d KeyframeGraph::covariance_over(const Constraint& edge, std::int64_t id) const {
  const bool forward = edge.to == id;
  const std::int64_t other = forward ? edge.from : edge.to;
  const Matrix6d of_edge = noise_.value() * without_common_errors(edge, options_), back = edge.rigid().adjoint();
  return moved_covariance(covariance(other), other, id) +
         (forward ? of_edge : Matrix6d(back * of_edge * back.transpose()));
}

/// The errors of one keyframe as those of another one that moves with it.
Matrix6d KeyframeGraph::moved_covariance(const Matrix6d& covariance, std::int64_t from, std::int64_t to) const {
  const Matrix6d to_right = (pose(to).inverse() * pose(from)).adjoint();
  return to_right * covariance * to_right.transpose();
}

void KeyframeGraph::settle_covariance(std::int64_t id) {
  double least = std::numeric_limits<double>::infinity();
  Matrix6d best = Matrix6d::Zero();
  for (const std::size_t e : edges_of_[static_cast<std::size_t>(id)]) {
    const Constraint& edge = edges_[e];
    const std::int64_t other = edge.to == id ? edge.from : edge.to;
    if (other > id || submap(other) != submap(id)) continue;
    const Matrix6d covariance = covariance_over(edge, id);
    if (covariance.trace() >= least) continue;
    least = covariance.trace();
    best = covariance;
  }
  if (std::isfinite(least)) covariances_[static_cast<std::size_t>(id)] = 0.5 * (best + best.transpose());
}

}  // namespace rastro
