// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rastro/backend/rgbd/keyframe_graph.h"
#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::bare_keyframe;
using testing::edge_of;
using testing::in_submap;
using testing::matrix_near;
using testing::random_vector;

/// Errors of neighboring edges have nothing in common.
RgbdSlamOptions independent_errors() {
  RgbdSlamOptions options;
  options.edge_sigma_m = options.edge_sigma_rad = 0.0;
  return options;
}

Matrix6d scaled_identity(const KeyframeGraph& graph, double variance) {
  return graph.variance_factor() * variance * Matrix6d::Identity();
}

void append(KeyframeGraph& graph, const SE3& pose, int submap = 0) {
  graph.add(bare_keyframe(graph.size(), 1), in_submap(pose, submap), Matrix6d::Zero());
}

/// The end of a chain, sampled a few thousand times: its spread is the predicted one.
TEST(KeyframeGraphCovariance, TheCovarianceOfAChainIsThatOfManySamples) {
  Random random(23);
  KeyframeGraph graph(independent_errors(), 0);
  std::vector<Constraint> edges;
  SE3 pose = SE3::exp(random_vector<Vector6d>(random, 0.7));
  append(graph, pose);
  for (int k = 1; k < 5; ++k) {
    const SE3 step = SE3::exp(random_vector<Vector6d>(random, 0.6));
    pose = pose * step;
    append(graph, pose);
    // Some edges lead from the new one to the old.
    edges.push_back(k % 2 == 1 ? edge_of(k - 1, k, step, ConstraintKind::odometry, 0.01, 0.004)
                               : edge_of(k, k - 1, step.inverse(), ConstraintKind::odometry, 0.003, 0.01));
    graph.add_edge(edges.back());
    graph.settle_covariance(k);
  }
  Matrix6d drawn = Matrix6d::Zero();
  constexpr int draws = 4000;
  for (int draw = 0; draw < draws; ++draw) {
    SE3 end = graph.pose(0);
    for (const Constraint& edge : edges) {
      Vector6d error;
      for (int i = 0; i < 6; ++i) error[i] = random.normal() / std::sqrt(edge.information(i, i));
      const SE3 sample = edge.rigid() * SE3::exp(error);
      end = end * (edge.from < edge.to ? sample : sample.inverse());
    }
    const Vector6d difference = (graph.pose(4).inverse() * end).log();
    drawn += graph.variance_factor() * difference * difference.transpose() / draws;
  }
  EXPECT_THAT(graph.covariance(4), matrix_near(drawn, 0.08 * drawn.diagonal().maxCoeff()));
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(graph.covariance(4)(i, i) / drawn(i, i), 1.0, 0.12) << i;
}

TEST(KeyframeGraphCovariance, CovarianceUsesTheBestNeighborOfTheSameSubmap) {
  KeyframeGraph graph(independent_errors(), 0);
  for (int k = 0; k < 4; ++k) append(graph, SE3(), k == 2 ? 1 : 0);
  graph.add_edge(edge_of(0, 1, SE3(), ConstraintKind::odometry, 0.1, 0.1));
  graph.settle_covariance(1);
  EXPECT_THAT(graph.covariance(1), matrix_near(scaled_identity(graph, 0.01), 1e-12));
  graph.add_edge(edge_of(1, 3, SE3(), ConstraintKind::odometry, 0.1, 0.1));
  graph.add_edge(edge_of(2, 3, SE3(), ConstraintKind::merge, 0.001, 0.001));
  graph.settle_covariance(3);
  EXPECT_THAT(graph.covariance(3), matrix_near(scaled_identity(graph, 0.02), 1e-12))
      << "another submap says nothing of this one's first";
  graph.add_edge(edge_of(0, 3, SE3(), ConstraintKind::loop, 0.05, 0.05));
  graph.settle_covariance(3);
  EXPECT_THAT(graph.covariance(3), matrix_near(scaled_identity(graph, 0.0025), 1e-12));
  graph.settle_covariance(0);
  EXPECT_THAT(graph.covariance(0), matrix_near(Matrix6d(Matrix6d::Zero()), 0.0)) << "nothing older holds it";
}

TEST(KeyframeGraphCovariance, ErrorsCommonToAllImagesDoNotAddUpAlongAPath) {
  RgbdSlamOptions options;
  options.edge_sigma_m = options.edge_sigma_rad = 0.1;
  KeyframeGraph graph(options, 0);
  for (int k = 0; k < 11; ++k) {
    append(graph, SE3());
    if (k > 0)
      graph.add_edge(edge_of(k - 1, k, SE3(), ConstraintKind::odometry, std::hypot(0.1, 0.02), std::hypot(0.1, 0.02)));
    graph.settle_covariance(k);
  }
  EXPECT_THAT(graph.covariance(10), matrix_near(scaled_identity(graph, 10.0 * 0.02 * 0.02), 1e-9));
}

TEST(KeyframeGraphCovariance, AMergedSubmapIsAsUncertainAsThePathToIt) {
  for (const bool forward : {true, false}) {
    KeyframeGraph graph(independent_errors(), 0);
    for (int k = 0; k < 4; ++k) append(graph, SE3(), k < 2 ? 0 : 1);
    graph.add_edge(edge_of(0, 1, SE3(), ConstraintKind::odometry, 0.1, 0.1));
    graph.add_edge(edge_of(2, 3, SE3(), ConstraintKind::odometry, 0.2, 0.2));
    for (const int k : {1, 3}) graph.settle_covariance(k);
    graph.merge(forward ? edge_of(1, 3, SE3(), ConstraintKind::merge, 0.3, 0.3)
                        : edge_of(3, 1, SE3(), ConstraintKind::merge, 0.3, 0.3));
    const GraphChanges changes = graph.take_changes();
    ASSERT_EQ(changes.covariances.size(), 2U) << "of the submap that was moved";
    for (const auto& [id, covariance] : changes.covariances)
      EXPECT_THAT(covariance, matrix_near(graph.covariance(id), 0.0)) << id;
    EXPECT_TRUE(graph.take_changes().covariances.empty()) << "told once";
    const double of_joint = 0.01 + 0.09, back = 0.04;
    EXPECT_THAT(graph.covariance(1), matrix_near(scaled_identity(graph, 0.01), 1e-12)) << "stays";
    EXPECT_THAT(graph.covariance(2), matrix_near(scaled_identity(graph, (of_joint + back)), 1e-12));
    EXPECT_THAT(graph.covariance(3), matrix_near(scaled_identity(graph, (of_joint + 2.0 * back)), 1e-12))
        << "an upper bound: on to the first of its submap and back";
  }
}

/// Residuals a tenth as large as the sigmas of the constraints.
TEST(KeyframeGraphCovariance, CovariancesAreAsLargeAsResidualsShow) {
  constexpr double sigma_m = 0.02, sigma_rad = 0.01, share = 0.1;
  KeyframeGraph graph(independent_errors(), 0);
  Random random(7);
  const double assumed = graph.variance_factor();
  for (int k = 0; k < 60; ++k) {
    append(graph, SE3(SO3(), Eigen::Vector3d(0.1 * k, 0.0, 0.0)));
    for (int other = std::max(0, k - 4); other < k; ++other) {
      Vector6d error = share * random_vector<Vector6d>(random, 1.0);
      error.head<3>() *= sigma_m, error.tail<3>() *= sigma_rad;
      const SE3 step(SO3(), Eigen::Vector3d(0.1 * (k - other), 0.0, 0.0));
      const auto kind = other == k - 1 ? ConstraintKind::odometry : ConstraintKind::proximity;
      graph.add_edge(edge_of(other, k, step * SE3::exp(error), kind, sigma_m, sigma_rad));
    }
  }
  graph.optimize(true);
  EXPECT_LT(graph.variance_factor(), 0.15 * assumed);
  KeyframeGraph given(independent_errors(), graph.size());
  for (std::int64_t k = 0; k < graph.size(); ++k) append(given, graph.pose(k));
  for (const Constraint& edge : graph.edges()) given.add_edge(edge);
  given.learn_noise();
  EXPECT_NEAR(given.variance_factor(), graph.variance_factor(), 0.05 * assumed) << "of a map that stays as it is";
}

}  // namespace
}  // namespace rastro
