// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstring>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/map/graph/planar.h"
#include "rastro/optimize/pose_graph.h"

/// For tests only: graphs in any space, exact except for the errors asked for.
namespace rastro::testing {

using GraphPoses = ::testing::Types<SE2, SE3, Sim3>;

template <GraphPose Pose>
typename Pose::Tangent random_tangent(double sigma, Random& random) {
  typename Pose::Tangent tangent;
  for (auto& value : tangent) value = sigma * random.normal();
  return tangent;
}

/// Forward, with a yaw, and with a small amount of the space's other components.
template <GraphPose Pose>
Pose motion(double ahead_m, double yaw_rad) {
  if constexpr (std::same_as<Pose, SE2>) {
    return {SO2::from_angle(yaw_rad), {ahead_m, 0.0}};
  } else {
    const SE3 rigid(SO3::exp({0.05, 0.0, yaw_rad}), {ahead_m, 0.0, 0.05});
    if constexpr (std::same_as<Pose, SE3>)
      return rigid;
    else
      return {1.01, rigid.rotation(), rigid.translation()};
  }
}

/// Twice around a square (rising in space), so that rotations exceed 180 degrees; the first pose is not the identity.
template <GraphPose Pose>
std::vector<Pose> square_loop() {
  typename Pose::Tangent start = Pose::Tangent::Constant(0.3);
  start[1] = -2.0;
  std::vector<Pose> poses{Pose::exp(start)};
  for (int k = 1; k < 32; ++k) poses.push_back(poses.back() * motion<Pose>(0.3, k % 4 == 0 ? M_PI / 2.0 : 0.02));
  return poses;
}

inline Sim3 similarity_of(const SE2& pose) { return Sim3(in_space(pose)); }
inline Sim3 similarity_of(const SE3& pose) { return Sim3(pose); }
inline Sim3 similarity_of(const Sim3& pose) { return pose; }

/// Anisotropic, and not aligned with the axes.
inline Matrix6d mixed_information() {
  Random random(5);
  Matrix6d mixed;
  for (int k = 0; k < 36; ++k) mixed(k / 6, k % 6) = random.normal();
  return 400.0 * Matrix6d::Identity() + 100.0 * mixed * mixed.transpose();
}

template <GraphPose Pose>
Constraint edge_between(const std::vector<Pose>& poses, std::size_t from, std::size_t to, ConstraintKind kind) {
  Constraint edge;
  edge.from = static_cast<KeyframeId>(from);
  edge.to = static_cast<KeyframeId>(to);
  edge.from_from_to = similarity_of(poses[from].inverse() * poses[to]);
  edge.kind = kind;
  edge.information = mixed_information();
  return edge;
}

/// Makes the edge wrong by a motion at its end.
template <GraphPose Pose>
void falsify(Constraint& edge, const Pose& by) {
  edge.from_from_to = edge.from_from_to * similarity_of(by);
}

/// Odometry edges between consecutive poses, and loop edges between the two rounds: the second half of `poses` revisits
/// the first.
template <GraphPose Pose>
std::vector<Constraint> loop_edges(const std::vector<Pose>& poses) {
  std::vector<Constraint> edges;
  for (std::size_t k = 1; k < poses.size(); ++k)
    edges.push_back(edge_between(poses, k - 1, k, ConstraintKind::odometry));
  const std::size_t round = poses.size() / 2;
  for (std::size_t k = 0; k + round < poses.size(); k += 3) {
    const bool back = k % 2 == 1;
    edges.push_back(edge_between(poses, back ? k + round : k, back ? k : k + round, ConstraintKind::loop));
  }
  return edges;
}

/// Perturbs all but the first.
template <GraphPose Pose>
std::vector<Pose> disturbed(std::vector<Pose> poses, double sigma, Random& random) {
  for (std::size_t k = 1; k < poses.size(); ++k) poses[k] = poses[k] * Pose::exp(random_tangent<Pose>(sigma, random));
  return poses;
}

template <GraphPose Pose>
std::vector<std::uint8_t> only_first(const std::vector<Pose>& poses) {
  std::vector<std::uint8_t> fixed(poses.size(), 0);
  fixed[0] = 1;
  return fixed;
}

/// Largest length of the tangent vector between corresponding poses.
template <GraphPose Pose>
double worst_error(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double worst = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) worst = std::max(worst, (a[k].inverse() * b[k]).log().norm());
  return worst;
}

/// Squared sigmas of an edge after its kernel: Cauchy's or a switch's.
inline double kernel_cost(double squared, const Constraint& edge, const PoseGraphOptions& options) {
  const double width = options.robust_width * options.robust_width, price = options.switch_price;
  if (edge.kind == ConstraintKind::odometry || options.loops == LoopModel::trusted) return squared;
  if (options.loops == LoopModel::robust) return width * std::log1p(squared / width);
  return price * squared / (price + squared);
}

template <GraphPose Pose>
double cost_of(const std::vector<Pose>& poses, const std::vector<Constraint>& edges, const PoseGraphOptions& options) {
  double cost = 0.0;
  for (const Constraint& edge : edges) {
    const Pose &from = poses[static_cast<std::size_t>(edge.from)], &to = poses[static_cast<std::size_t>(edge.to)];
    cost += 0.5 * kernel_cost(squared_sigmas(edge, from, to, options), edge, options);
  }
  return cost;
}

template <GraphPose Pose>
bool same_bytes(const Pose& a, const Pose& b) {
  const auto first = a.matrix(), second = b.matrix();
  return std::memcmp(first.data(), second.data(), sizeof(first)) == 0;
}

}  // namespace rastro::testing
