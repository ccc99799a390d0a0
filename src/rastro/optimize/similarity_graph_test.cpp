// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/similarity_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "rastro/base/random.h"

namespace rastro {
namespace {

Vector7d random_tangent(Random& random, double size, bool with_scale) {
  Vector7d tangent;
  for (int k = 0; k < 7; ++k) tangent[k] = size * random.normal();
  if (!with_scale) tangent[6] = 0.0;
  return tangent;
}

/// Round a circle; scale 1 throughout.
std::vector<Sim3> circle() {
  std::vector<Sim3> poses;
  for (int k = 0; k < 40; ++k) {
    const double angle = 2.0 * M_PI * k / 40.0;
    poses.emplace_back(1.0, SO3::exp({0.0, 0.1, angle}),
                       Eigen::Vector3d(5.0 * std::sin(angle), 5.0 * std::cos(angle), 0.1 * k));
  }
  return poses;
}

std::vector<SimilarityEdge> edges_of(const std::vector<Sim3>& poses) {
  std::vector<SimilarityEdge> edges;
  for (std::uint32_t k = 0; k + 1 < poses.size(); ++k) {
    edges.push_back({k, k + 1, poses[k].inverse() * poses[k + 1], 1.0});
    if (k % 4 == 0 && k + 3 < poses.size()) edges.push_back({k + 3, k, poses[k + 3].inverse() * poses[k], 2.0});
  }
  return edges;
}

std::vector<std::uint8_t> only_first(std::size_t count) {
  std::vector<std::uint8_t> fixed(count, 0);
  fixed[0] = 1;
  return fixed;
}

double cost_of(const std::vector<Sim3>& poses, const std::vector<SimilarityEdge>& edges) {
  double cost = 0.0;
  for (const SimilarityEdge& edge : edges)
    cost += 0.5 * edge.weight *
            (edge.from_from_to.inverse() * poses[edge.from].inverse() * poses[edge.to]).log().squaredNorm();
  return cost;
}

double worst(const std::vector<Sim3>& a, const std::vector<Sim3>& b) {
  double result = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) result = std::max(result, (a[k].inverse() * b[k]).log().norm());
  return result;
}

TEST(SimilarityGraph, ADisturbedGraphComesBackToTruth) {
  for (const bool fix_scale : {false, true}) {
    Random random(1);
    const std::vector<Sim3> truth = circle();
    const auto edges = edges_of(truth);
    std::vector<Sim3> poses = truth;
    for (std::size_t k = 1; k < poses.size(); ++k)
      poses[k] = poses[k] * Sim3::exp(random_tangent(random, 0.1, !fix_scale));
    const auto result = optimize_similarity_graph(poses, edges, only_first(poses.size()), {fix_scale, 50});
    EXPECT_TRUE(result.converged);
    EXPECT_LT(result.last_cost, 1e-8 * result.first_cost);
    EXPECT_LT(worst(poses, truth), 1e-3);
  }
}

TEST(SimilarityGraph, ALoopTakesOutTheDriftOfScale) {
  const std::vector<Sim3> truth = circle();
  // Each step is 1 % longer than the one before in the unit of the first.
  std::vector<Sim3> poses{truth[0]};
  std::vector<SimilarityEdge> edges;
  for (std::uint32_t k = 0; k + 1 < truth.size(); ++k) {
    const Sim3 step = truth[k].inverse() * truth[k + 1] * Sim3(1.01, SO3(), Eigen::Vector3d::Zero());
    poses.push_back(poses.back() * step);
    edges.push_back({k, k + 1, step, 1.0});
  }
  const auto last = static_cast<std::uint32_t>(truth.size() - 1);
  edges.push_back({last, 0, truth[last].inverse() * truth[0], 1.0});
  ASSERT_GT(poses[last].scale(), 1.45);
  optimize_similarity_graph(poses, edges, only_first(poses.size()), {false, 100});
  EXPECT_NEAR(poses[last].scale(), 1.0, 0.02);
  EXPECT_LT((poses[last].translation() - truth[last].translation()).norm(), 0.2);
  // What the loop said of the scale is now spread over all.
  EXPECT_NEAR(poses[20].scale(), 1.0, 0.05);
}

TEST(SimilarityGraph, WhereEdgesDisagreeNoStepLowersTheCost) {
  Random random(2);
  const std::vector<Sim3> truth = circle();
  auto edges = edges_of(truth);
  for (SimilarityEdge& edge : edges)
    edge.from_from_to = edge.from_from_to * Sim3::exp(random_tangent(random, 0.1, true));
  for (const bool fix_scale : {false, true}) {
    std::vector<Sim3> poses = truth;
    const auto result = optimize_similarity_graph(poses, edges, only_first(poses.size()), {fix_scale, 300});
    EXPECT_NEAR(result.last_cost, cost_of(poses, edges), 1e-6 * result.last_cost);
    EXPECT_GT(result.last_cost, 0.01) << "the edges must disagree";
    for (std::size_t k = 1; k < poses.size(); k += 3) {
      for (int axis = 0; axis < (fix_scale ? 12 : 14); ++axis) {
        std::vector<Sim3> other = poses;
        Vector7d step = Vector7d::Zero();
        step[axis / 2] = axis % 2 == 0 ? 2e-3 : -2e-3;
        other[k] = poses[k] * Sim3::exp(step);
        EXPECT_GT(cost_of(other, edges), result.last_cost) << k << ' ' << axis;
      }
      EXPECT_TRUE(!fix_scale || std::abs(poses[k].scale() - 1.0) < 1e-12);
    }
  }
}

TEST(SimilarityGraph, WhatIsFixedOrHeldByNothingStaysAndTwiceIsTheSame) {
  Random random(3);
  std::vector<Sim3> start = circle();
  const auto edges = edges_of(start);
  for (Sim3& pose : start) pose = pose * Sim3::exp(random_tangent(random, 0.1, true));
  start.emplace_back(2.0, SO3(), Eigen::Vector3d(1, 2, 3));
  std::vector<std::uint8_t> fixed(start.size(), 0);
  for (std::size_t k = 0; k < 10; ++k) fixed[k] = 1;
  std::vector<Sim3> first = start, second = start, none;
  optimize_similarity_graph(first, edges, fixed, {});
  optimize_similarity_graph(second, edges, fixed, {});
  for (std::size_t k = 0; k < start.size(); ++k) {
    const Eigen::Matrix4d a = first[k].matrix(), b = second[k].matrix();
    EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * 16), 0);
    EXPECT_EQ((a - start[k].matrix()).norm() == 0.0, k < 10 || k + 1 == start.size()) << k;
  }
  EXPECT_TRUE(optimize_similarity_graph(none, {}, {}, {}).converged);
}

}  // namespace
}  // namespace rastro
