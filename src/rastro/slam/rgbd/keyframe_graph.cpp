// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rgbd/keyframe_graph.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"

namespace rastro {
namespace {

/// `count` of them drawn at random, in their order.
std::vector<std::int64_t> drawn(std::vector<std::int64_t> from, int count, Random& random) {
  const auto most = std::min(from.size(), static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < most; ++i)
    std::swap(from[i], from[i + random.below(static_cast<std::uint32_t>(from.size() - i))]);
  from.resize(most);
  std::sort(from.begin(), from.end());
  return from;
}

PoseGraphOptions graph_options(const RgbdSlamOptions& options) {
  PoseGraphOptions graph;
  graph.loops = options.loops == "robust" ? LoopModel::robust : LoopModel::switchable;
  graph.switch_price = options.switch_price;
  graph.robust_width = options.robust_width;
  graph.iterations = options.optimize_iterations;
  return graph;
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
  covariances_.push_back(covariance);
  edges_of_.emplace_back();
}

void KeyframeGraph::add_edge(const Constraint& edge) {
  edges_of_[static_cast<std::size_t>(edge.from)].push_back(edges_.size());
  edges_of_[static_cast<std::size_t>(edge.to)].push_back(edges_.size());
  edges_.push_back(edge);
}

void KeyframeGraph::forget_features(std::int64_t id) {
  auto& place = keyframes_[static_cast<std::size_t>(id)];
  auto bare = std::make_shared<ImageFeatures>();
  bare->id = place->id;
  bare->frame = place->frame;
  bare->stamp = place->stamp;
  bare->features.length = place->features.length;
  place = std::move(bare);
}

std::vector<KeyframePose> KeyframeGraph::keyframe_poses() const {
  std::vector<KeyframePose> result;
  result.reserve(poses_.size());
  for (std::size_t i = 0; i < poses_.size(); ++i) result.push_back({poses_[i], submaps_[i]});
  return result;
}

std::vector<std::int64_t> KeyframeGraph::neighbourhood(std::int64_t id, int steps) const {
  std::vector<std::int64_t> found{id};
  for (std::size_t from = 0; steps > 0; --steps) {
    const std::size_t end = found.size();
    for (; from < end; ++from) {
      for (const std::size_t e : edges_of_[static_cast<std::size_t>(found[from])]) {
        const std::int64_t other = edges_[e].from == found[from] ? edges_[e].to : edges_[e].from;
        if (std::find(found.begin(), found.end(), other) == found.end()) found.push_back(other);
      }
    }
  }
  return found;
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
        const std::int64_t other = edges_[e].from == found[next] ? edges_[e].to : edges_[e].from;
        if (seen[static_cast<std::size_t>(other)] != 0) continue;
        seen[static_cast<std::size_t>(other)] = 1;
        found.push_back(other);
      }
    }
  }
  return most;
}

std::vector<std::int64_t> KeyframeGraph::candidates(std::int64_t id, Random& random) const {
  // In a map made before, what was just seen says nothing of where that is.
  const std::int64_t end = frozen_ > 0 ? frozen_ : id;
  std::vector<std::uint8_t> taken(keyframes_.size(), 0);
  std::vector<std::int64_t> chosen;
  const auto take = [&](std::int64_t other) {
    if (other < 0 || other >= end || taken[static_cast<std::size_t>(other)] != 0) return;
    taken[static_cast<std::size_t>(other)] = 1;
    chosen.push_back(other);
  };
  const auto free = [&](auto&& allowed) {
    std::vector<std::int64_t> all;
    for (std::int64_t other = 0; other < end; ++other) {
      if (taken[static_cast<std::size_t>(other)] == 0 && keyframe(other).features.size() > 0 && allowed(other))
        all.push_back(other);
    }
    return all;
  };
  if (frozen_ == 0) {
    for (std::int64_t k = 1; k <= options_.last_candidates; ++k) take(id - k);
  }
  // Nearest by where they look from and to.
  const auto distance = [&](std::int64_t other) {
    const SE3 apart = pose(other).inverse() * pose(id);
    return std::max(apart.translation().norm() / options_.near_distance_m,
                    apart.rotation().log().norm() / options_.near_angle_rad);
  };
  std::vector<std::pair<double, std::int64_t>> near;
  for (const std::int64_t other : free([&](std::int64_t k) { return submap(k) == submap(id); })) {
    if (const double far = distance(other); far < 1.0) near.emplace_back(far, other);
  }
  std::sort(near.begin(), near.end());
  for (std::size_t k = 0; k < near.size() && k < static_cast<std::size_t>(options_.near_candidates); ++k)
    take(near[k].second);
  constexpr int reach = 3;
  std::vector<std::int64_t> around = neighbourhood(id, reach);
  std::erase_if(around, [&](std::int64_t k) { return k >= end || taken[static_cast<std::size_t>(k)] != 0; });
  std::sort(around.begin(), around.end());
  for (const std::int64_t other : drawn(around, options_.graph_candidates, random)) take(other);
  const auto elsewhere = free([&](std::int64_t k) { return submap(k) != submap(id); });
  for (const std::int64_t other : drawn(elsewhere, options_.join_candidates, random)) take(other);
  for (const std::int64_t other : drawn(free([](std::int64_t) { return true; }), options_.random_candidates, random))
    take(other);
  return chosen;
}

void KeyframeGraph::join(const Constraint& edge) {
  const int a = submap(edge.from), b = submap(edge.to);
  if (a == b) return;
  const SE3 a_from_b = pose(edge.from) * edge.rigid() * pose(edge.to).inverse();
  const int kept = std::min(a, b), moved = std::max(a, b);
  const SE3 kept_from_moved = kept == a ? a_from_b : a_from_b.inverse();
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    if (submaps_[k] != moved) continue;
    poses_[k] = kept_from_moved * poses_[k];
    submaps_[k] = kept;
  }
}

PoseGraphResult KeyframeGraph::optimize(bool all) {
  std::vector<std::uint8_t> fixed(poses_.size(), 0);
  const std::int64_t first_free = all ? frozen_ : std::max(frozen_, size() - options_.graph_window);
  std::vector<int> anchored;
  for (std::int64_t k = 0; k < size(); ++k) {
    // The first of each submap says where it is.
    const bool first = std::find(anchored.begin(), anchored.end(), submap(k)) == anchored.end();
    if (first) anchored.push_back(submap(k));
    fixed[static_cast<std::size_t>(k)] = k < first_free || (first && frozen_ == 0) ? 1 : 0;
  }
  return optimize_pose_graph(poses_, edges_, fixed, graph_options(options_));
}

void KeyframeGraph::settle_covariance(std::int64_t id) {
  double least = std::numeric_limits<double>::infinity();
  Matrix6d best = Matrix6d::Zero();
  for (const std::size_t e : edges_of_[static_cast<std::size_t>(id)]) {
    const Constraint& edge = edges_[e];
    const bool forward = edge.to == id;
    const std::int64_t other = forward ? edge.from : edge.to;
    if (other > id || submap(other) != submap(id)) continue;
    const Matrix6d of_edge = edge.information.inverse();
    const Matrix6d to_right = pose(id).inverse().adjoint() * pose(other).adjoint();
    const Matrix6d back = edge.rigid().adjoint();
    Matrix6d covariance = to_right * this->covariance(other) * to_right.transpose();
    covariance += forward ? of_edge : Matrix6d(back * of_edge * back.transpose());
    if (covariance.trace() >= least) continue;
    least = covariance.trace();
    best = covariance;
  }
  if (std::isfinite(least)) covariances_[static_cast<std::size_t>(id)] = 0.5 * (best + best.transpose());
}

}  // namespace rastro
