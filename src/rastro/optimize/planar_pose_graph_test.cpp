// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/planar_pose_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

SE2 pose_of(double x, double y, double angle) { return {SO2::from_angle(angle), {x, y}}; }

/// Twice round a square of 6 m in steps of 1 m, so that the angles pass pi; pose 0 is not the origin.
std::vector<SE2> square_loop() {
  std::vector<SE2> poses{pose_of(1.0, -2.0, 0.4)};
  for (int k = 1; k < 48; ++k) {
    const double turn = k % 6 == 0 ? M_PI / 2.0 : 0.0;
    poses.push_back(poses.back() * pose_of(1.0, 0.0, turn));
  }
  return poses;
}

PlanarEdge edge_between(const std::vector<SE2>& truth, std::size_t a, std::size_t b) {
  PlanarEdge edge{a, b, truth[a].inverse() * truth[b]};
  edge.root_information << 20.0, 3.0, 1.0, 0.0, 30.0, -2.0, 0.0, 0.0, 60.0;
  return edge;
}

/// From each pose to the next, and from each to where the second round passes it.
std::vector<PlanarEdge> loop_edges(const std::vector<SE2>& truth) {
  std::vector<PlanarEdge> edges;
  for (std::size_t k = 1; k < truth.size(); ++k) edges.push_back(edge_between(truth, k - 1, k));
  for (std::size_t k = 0; k + 24 < truth.size(); k += 3) edges.push_back(edge_between(truth, k, k + 24));
  return edges;
}

std::vector<SE2> disturbed(std::vector<SE2> poses, double sigma_m, double sigma_rad, Random& random) {
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const Eigen::Vector2d off(sigma_m * random.normal(), sigma_m * random.normal());
    poses[k] = {poses[k].rotation() * SO2::from_angle(sigma_rad * random.normal()), poses[k].translation() + off};
  }
  return poses;
}

double worst_distance(const std::vector<SE2>& a, const std::vector<SE2>& b) {
  double worst = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    worst = std::max(worst, (a[k].translation() - b[k].translation()).norm());
    worst = std::max(worst, std::abs((a[k].rotation().inverse() * b[k].rotation()).angle()));
  }
  return worst;
}

/// Half the sum of squares, with Cauchy's loss for what may be wrong.
double cost_of(const std::vector<SE2>& poses, const std::vector<PlanarEdge>& edges, double robust_width) {
  double cost = 0.0;
  for (const PlanarEdge& edge : edges) {
    const double squared = planar_edge_error(edge, poses[edge.a], poses[edge.b]).squaredNorm();
    const double width = robust_width * robust_width;
    cost += 0.5 * (edge.robust ? width * std::log1p(squared / width) : squared);
  }
  return cost;
}

SE2 stepped(const SE2& pose, int axis, double step) {
  Eigen::Vector3d by = Eigen::Vector3d::Zero();
  by[axis] = step;
  return {pose.rotation() * SO2::from_angle(by.z()), pose.translation() + by.head<2>()};
}

bool same_bytes(const std::vector<SE2>& a, const std::vector<SE2>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Eigen::Matrix3d first = a[k].matrix(), second = b[k].matrix();
    if (std::memcmp(first.data(), second.data(), 9 * sizeof(double)) != 0) return false;
  }
  return a.size() == b.size();
}

TEST(PlanarPoseGraph, ErrorIsWhatTheEdgeSaysInSigmas) {
  PlanarEdge edge{0, 1, pose_of(2.0, 1.0, 3.0)};
  edge.root_information << 10.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 100.0;
  const SE2 a = pose_of(4.0, -1.0, M_PI / 2.0);
  EXPECT_LT(planar_edge_error(edge, a, a * edge.a_from_b).norm(), 1e-12);
  // In a's frame, and over the seam of angles.
  const SE2 b = a * pose_of(2.1, 0.8, 3.0 + 0.3);
  EXPECT_LT((planar_edge_error(edge, a, b) - Eigen::Vector3d(1.0, -1.0, 30.0)).norm(), 1e-9);
}

TEST(PlanarPoseGraph, ADisturbedLoopComesBackToTruth) {
  const std::vector<SE2> truth = square_loop();
  const std::vector<PlanarEdge> edges = loop_edges(truth);
  Random random(2);
  for (int round = 0; round < 5; ++round) {
    const std::vector<SE2> start = disturbed(truth, 0.5, 0.2, random);
    std::vector<SE2> poses = start;
    const PlanarPoseGraphResult result = optimize_planar_pose_graph(poses, edges, {});
    EXPECT_TRUE(result.converged);
    EXPECT_NEAR(result.first_cost, cost_of(start, edges, 2.0), 1e-6 * result.first_cost);
    EXPECT_LT(result.last_cost, 1e-9 * result.first_cost);
    EXPECT_LT(worst_distance(poses, truth), 1e-4);
  }
}

TEST(PlanarPoseGraph, WhereEdgesDisagreeTheCostIsLeast) {
  // Wrong derivatives would stop elsewhere: no step of any pose along any axis may lower the cost.
  const std::vector<SE2> truth = square_loop();
  std::vector<PlanarEdge> edges = loop_edges(truth);
  Random random(3);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    edges[i].a_from_b = disturbed({SE2(), edges[i].a_from_b}, 0.05, 0.02, random)[1];
    edges[i].robust = i % 3 == 0;
  }
  std::vector<SE2> poses = disturbed(truth, 0.2, 0.1, random);
  const PlanarPoseGraphResult result = optimize_planar_pose_graph(poses, edges, {2.0, 200});
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.last_cost, cost_of(poses, edges, 2.0), 1e-9 * result.last_cost);
  EXPECT_GT(result.last_cost, 1.0) << "the edges must disagree";
  for (std::size_t k = 1; k < poses.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double step : {-1e-3, 1e-3}) {
        std::vector<SE2> other = poses;
        other[k] = stepped(poses[k], axis, step);
        EXPECT_GT(cost_of(other, edges, 2.0), result.last_cost) << k << ' ' << axis;
      }
    }
  }
}

TEST(PlanarPoseGraph, AWrongEdgeThatMayBeWrongMovesItLittle) {
  const std::vector<SE2> truth = square_loop();
  std::vector<PlanarEdge> edges = loop_edges(truth);
  PlanarEdge wrong = edge_between(truth, 4, 35);
  wrong.a_from_b = wrong.a_from_b * pose_of(3.0, -2.0, 1.0);
  edges.push_back(wrong);
  std::vector<SE2> pulled = truth, kept = truth;
  optimize_planar_pose_graph(pulled, edges, {});
  edges.back().robust = true;
  optimize_planar_pose_graph(kept, edges, {});
  EXPECT_GT(worst_distance(pulled, truth), 0.3);
  EXPECT_LT(worst_distance(kept, truth), 0.02);
}

TEST(PlanarPoseGraph, TheFirstPoseAndWhatNoEdgeHoldsStay) {
  Random random(4);
  std::vector<SE2> truth = square_loop();
  const std::vector<PlanarEdge> edges = loop_edges(truth);
  truth.push_back(pose_of(7.0, 8.0, -2.0));
  std::vector<SE2> poses = disturbed(truth, 0.3, 0.1, random);
  const std::vector<SE2> start = poses;
  optimize_planar_pose_graph(poses, edges, {});
  for (const std::size_t k : {std::size_t{0}, poses.size() - 1}) {
    EXPECT_LT((poses[k].matrix() - start[k].matrix()).norm(), 1e-14);
  }
  EXPECT_GT(worst_distance(poses, start), 0.1);
}

TEST(PlanarPoseGraph, NothingToDoIsDone) {
  std::vector<SE2> none;
  EXPECT_TRUE(optimize_planar_pose_graph(none, {}, {}).converged);
  std::vector<SE2> one{pose_of(1.0, 2.0, 3.0)};
  EXPECT_TRUE(optimize_planar_pose_graph(one, {}, {}).converged);
  EXPECT_EQ(one[0].translation(), Eigen::Vector2d(1.0, 2.0));
}

TEST(PlanarPoseGraph, GivesTheSameBytesTwice) {
  Random random(6);
  const std::vector<SE2> truth = square_loop();
  std::vector<PlanarEdge> edges = loop_edges(truth);
  for (PlanarEdge& edge : edges) edge.robust = edge.b > edge.a + 1;
  const std::vector<SE2> start = disturbed(truth, 0.3, 0.1, random);
  std::vector<SE2> first = start, second = start;
  optimize_planar_pose_graph(first, edges, {});
  optimize_planar_pose_graph(second, edges, {});
  EXPECT_TRUE(same_bytes(first, second));
  EXPECT_FALSE(same_bytes(first, start));
}

}  // namespace
}  // namespace rastro
