// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/pose_graph.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

Vector6d random_tangent(double sigma_m, double sigma_rad, Random& random) {
  Vector6d tangent;
  for (int k = 0; k < 6; ++k) tangent[k] = (k < 3 ? sigma_m : sigma_rad) * random.normal();
  return tangent;
}

/// Twice round a rising square, so that rotations pass half a turn; the first pose is not the identity.
std::vector<SE3> square_loop() {
  const SE3 ahead(SO3::exp({0.05, 0.0, 0.02}), {0.3, 0.0, 0.05}),
      turn(SO3::exp({0.0, 0.0, M_PI / 2.0}), {0.3, 0.0, 0.0});
  std::vector<SE3> poses{SE3(SO3::exp({0.3, -0.4, 0.5}), {1.0, -2.0, 0.5})};
  for (int k = 1; k < 32; ++k) poses.push_back(poses.back() * (k % 4 == 0 ? turn : ahead));
  return poses;
}

Constraint edge_between(const std::vector<SE3>& truth, std::size_t from, std::size_t to, ConstraintKind kind) {
  Constraint edge;
  edge.from = static_cast<std::int64_t>(from);
  edge.to = static_cast<std::int64_t>(to);
  edge.from_from_to = Sim3(truth[from].inverse() * truth[to]);
  edge.kind = kind;
  // Sure of some directions more than of others, and not along the axes.
  Random random(5);
  Matrix6d mixed;
  for (int k = 0; k < 36; ++k) mixed(k / 6, k % 6) = random.normal();
  edge.information = 400.0 * Matrix6d::Identity() + 100.0 * mixed * mixed.transpose();
  return edge;
}

std::vector<Constraint> loop_edges(const std::vector<SE3>& truth) {
  std::vector<Constraint> edges;
  for (std::size_t k = 1; k < truth.size(); ++k)
    edges.push_back(edge_between(truth, k - 1, k, ConstraintKind::odometry));
  for (std::size_t k = 0; k + 16 < truth.size(); k += 3)
    edges.push_back(edge_between(truth, k, k + 16, ConstraintKind::loop));
  return edges;
}

std::vector<SE3> disturbed(std::vector<SE3> poses, double sigma_m, double sigma_rad, Random& random) {
  for (std::size_t k = 1; k < poses.size(); ++k)
    poses[k] = poses[k] * SE3::exp(random_tangent(sigma_m, sigma_rad, random));
  return poses;
}

std::vector<std::uint8_t> only_first(const std::vector<SE3>& poses) {
  std::vector<std::uint8_t> fixed(poses.size(), 0);
  fixed[0] = 1;
  return fixed;
}

double worst_error(const std::vector<SE3>& a, const std::vector<SE3>& b) {
  double worst = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) worst = std::max(worst, (a[k].inverse() * b[k]).log().norm());
  return worst;
}

double cost_of(const std::vector<SE3>& poses, const std::vector<Constraint>& edges, const PoseGraphOptions& options) {
  double cost = 0.0;
  for (const Constraint& edge : edges) {
    const double squared =
        squared_sigmas(edge, poses[static_cast<std::size_t>(edge.from)], poses[static_cast<std::size_t>(edge.to)]);
    const double width = options.robust_width * options.robust_width, price = options.switch_price;
    if (edge.kind == ConstraintKind::odometry || options.loops == LoopModel::trusted) {
      cost += 0.5 * squared;
    } else {
      cost += 0.5 * (options.loops == LoopModel::robust ? width * std::log1p(squared / width)
                                                        : price * squared / (price + squared));
    }
  }
  return cost;
}

TEST(PoseGraph, ErrorIsWhatTheEdgeLeavesOpenAtItsEnd) {
  const std::vector<SE3> truth = square_loop();
  const Constraint edge = edge_between(truth, 2, 9, ConstraintKind::loop);
  EXPECT_LT(pose_edge_error(edge, truth[2], truth[9]).norm(), 1e-12);
  Vector6d off;
  off << 0.1, -0.2, 0.3, 0.04, -0.05, 0.06;
  EXPECT_LT((pose_edge_error(edge, truth[2], truth[9] * SE3::exp(off)) - off).norm(), 1e-12);
  EXPECT_NEAR(squared_sigmas(edge, truth[2], truth[9] * SE3::exp(off)), off.dot(edge.information * off), 1e-6);
}

TEST(PoseGraph, ADisturbedLoopComesBackToTruth) {
  const std::vector<SE3> truth = square_loop();
  std::vector<Constraint> edges = loop_edges(truth);
  Random random(2);
  for (const LoopModel loops : {LoopModel::switchable, LoopModel::robust, LoopModel::trusted}) {
    std::vector<SE3> poses = disturbed(truth, 0.2, 0.15, random);
    PoseGraphOptions options;
    options.loops = loops;
    options.iterations = 50;
    const PoseGraphResult result = optimize_pose_graph(poses, edges, only_first(poses), options);
    EXPECT_TRUE(result.converged);
    EXPECT_LT(result.last_cost, 1e-9 * result.first_cost);
    EXPECT_LT(worst_error(poses, truth), 1e-4);
    for (const Constraint& edge : edges) EXPECT_NEAR(edge.weight, 1.0, 1e-4);
  }
}

TEST(PoseGraph, WhereEdgesDisagreeNoStepLowersTheCost) {
  // Wrong derivatives would stop elsewhere. One degree of rotation about the far end is what they are most easily wrong
  // in.
  const std::vector<SE3> truth = square_loop();
  Random random(3);
  for (const LoopModel loops : {LoopModel::switchable, LoopModel::robust}) {
    std::vector<Constraint> edges = loop_edges(truth);
    for (Constraint& edge : edges)
      edge.from_from_to = Sim3(edge.rigid() * SE3::exp(random_tangent(0.03, 0.03, random)));
    std::vector<SE3> poses = disturbed(truth, 0.1, 0.1, random);
    PoseGraphOptions options{loops, 100.0, 8.0, 300};
    const PoseGraphResult result = optimize_pose_graph(poses, edges, only_first(poses), options);
    EXPECT_NEAR(result.last_cost, cost_of(poses, edges, options), 1e-6 * result.last_cost);
    EXPECT_GT(result.last_cost, 1.0) << "the edges must disagree";
    for (std::size_t k = 1; k < poses.size(); ++k) {
      for (int axis = 0; axis < 12; ++axis) {
        std::vector<SE3> other = poses;
        Vector6d step = Vector6d::Zero();
        step[axis / 2] = axis % 2 == 0 ? 2e-3 : -2e-3;
        other[k] = poses[k] * SE3::exp(step);
        EXPECT_GT(cost_of(other, edges, options), result.last_cost) << k << ' ' << axis;
      }
    }
  }
}

TEST(PoseGraph, AWrongLoopIsTurnedOffAndTrueOnesAfterALongDriftAreNot) {
  const std::vector<SE3> truth = square_loop();
  std::vector<Constraint> edges = loop_edges(truth);
  edges.push_back(edge_between(truth, 4, 25, ConstraintKind::loop));
  edges.back().from_from_to = Sim3(edges.back().rigid() * SE3(SO3::exp({0.0, 0.5, 0.0}), {1.5, -1.0, 0.0}));
  // The way bends, as odometry's does: its end is far off, and so are the true loops.
  std::vector<SE3> poses{truth[0]};
  const SE3 bend = SE3::exp((Vector6d() << 0.01, 0.005, 0.0, 0.0, 0.01, 0.01).finished());
  for (std::size_t k = 1; k < truth.size(); ++k) poses.push_back(poses.back() * edges[k - 1].rigid() * bend);
  ASSERT_GT((poses.back().translation() - truth.back().translation()).norm(), 0.15);
  PoseGraphOptions options;
  options.iterations = 50;
  optimize_pose_graph(poses, edges, only_first(poses), options);
  EXPECT_LT(worst_error(poses, truth), 0.03);
  EXPECT_LT(edges.back().weight, 0.01);
  for (std::size_t e = 0; e + 1 < edges.size(); ++e) EXPECT_GT(edges[e].weight, 0.9) << e;
  options.loops = LoopModel::trusted;
  optimize_pose_graph(poses, edges, only_first(poses), options);
  EXPECT_GT(worst_error(poses, truth), 0.1) << "it must pull where it is believed";
}

TEST(PoseGraph, WhatIsFixedOrHeldByNothingStays) {
  Random random(4);
  std::vector<SE3> truth = square_loop();
  std::vector<Constraint> edges = loop_edges(truth);
  truth.push_back(SE3(SO3::exp({1.0, 2.0, 0.5}), {7.0, 8.0, 9.0}));
  const std::vector<SE3> start = disturbed(truth, 0.1, 0.1, random);
  std::vector<std::uint8_t> fixed(start.size(), 1);
  for (std::size_t k = 20; k < fixed.size(); ++k) fixed[k] = 0;
  std::vector<SE3> poses = start;
  for (Constraint& edge : edges) edge.weight = -1.0;
  optimize_pose_graph(poses, edges, fixed, {});
  const auto same = [&](std::size_t k) { return (poses[k].matrix() - start[k].matrix()).norm() < 1e-14; };
  for (std::size_t k = 0; k < poses.size(); ++k) EXPECT_EQ(same(k), k < 20 || k + 1 == poses.size()) << k;
  for (const Constraint& edge : edges) EXPECT_EQ(edge.weight < 0.0, edge.from < 20 && edge.to < 20);
}

TEST(PoseGraph, NothingToDoIsDoneAndTwiceTheSameBytes) {
  std::vector<SE3> none;
  EXPECT_TRUE(optimize_pose_graph(none, {}, {}, {}).converged);
  Random random(6);
  const std::vector<SE3> truth = square_loop();
  std::vector<Constraint> edges = loop_edges(truth);
  std::vector<SE3> first = disturbed(truth, 0.2, 0.1, random), second = first;
  optimize_pose_graph(first, edges, only_first(first), {});
  optimize_pose_graph(second, edges, only_first(second), {});
  for (std::size_t k = 0; k < first.size(); ++k) {
    const Eigen::Matrix4d a = first[k].matrix(), b = second[k].matrix();
    EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * 16), 0) << k;
  }
}

}  // namespace
}  // namespace rastro
