// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/pose_graph.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/optimize/pose_graph_testing.h"

namespace rastro {
namespace {

using testing::cost_of;
using testing::disturbed;
using testing::edge_between;
using testing::loop_edges;
using testing::only_first;
using testing::same_bytes;
using testing::square_loop;
using testing::worst_error;

/// Properties that hold in every space.
template <typename Pose>
class PoseGraph : public ::testing::Test {
 protected:
  static PoseGraphOptions options(LoopModel loops) {
    PoseGraphOptions options;
    options.loops = loops;
    options.iterations = 50;
    options.scale_information = 700.0;
    return options;
  }

  const std::vector<Pose> ground_truth = square_loop<Pose>();
  std::vector<Constraint> edges = loop_edges(ground_truth);
};
TYPED_TEST_SUITE(PoseGraph, testing::GraphPoses);

TYPED_TEST(PoseGraph, APerturbedLoopConvergesToGroundTruth) {
  Random random(2);
  for (const LoopModel loops : {LoopModel::switchable, LoopModel::robust, LoopModel::trusted}) {
    const PoseGraphOptions options = this->options(loops);
    const std::vector<TypeParam> start = disturbed(this->ground_truth, 0.15, random);
    std::vector<TypeParam> poses = start;
    const PoseGraphResult result = optimize_pose_graph(poses, this->edges, only_first(poses), options);
    EXPECT_TRUE(result.converged);
    if (loops != LoopModel::switchable) {
      EXPECT_NEAR(result.first_cost, cost_of(start, this->edges, options), 1e-6 * result.first_cost);
    }
    EXPECT_LT(result.last_cost, 1e-9 * result.first_cost);
    EXPECT_LT(worst_error(poses, this->ground_truth), 1e-4);
    for (const Constraint& edge : this->edges) EXPECT_NEAR(edge.weight, 1.0, 1e-4);
  }
}

TYPED_TEST(PoseGraph, WithInconsistentEdgesNoStepLowersTheCost) {
  // Wrong derivatives would stop elsewhere.
  Random random(3);
  for (const LoopModel loops : {LoopModel::switchable, LoopModel::robust, LoopModel::trusted}) {
    std::vector<Constraint> disagreeing = this->edges;
    for (Constraint& edge : disagreeing)
      testing::falsify(edge, TypeParam::exp(testing::random_tangent<TypeParam>(0.03, random)));
    std::vector<TypeParam> poses = disturbed(this->ground_truth, 0.1, random);
    PoseGraphOptions options = this->options(loops);
    options.switch_price = 100.0;
    options.robust_width = 8.0;
    options.iterations = 300;
    const PoseGraphResult result = optimize_pose_graph(poses, disagreeing, only_first(poses), options);
    EXPECT_NEAR(result.last_cost, cost_of(poses, disagreeing, options), 1e-6 * result.last_cost);
    EXPECT_GT(result.last_cost, 1.0) << "the edges must disagree";
    for (std::size_t k = 1; k < poses.size(); k += 2) {
      const TypeParam best = poses[k];
      for (int axis = 0; axis < 2 * TypeParam::Tangent::RowsAtCompileTime; ++axis) {
        typename TypeParam::Tangent step = TypeParam::Tangent::Zero();
        step[axis / 2] = axis % 2 == 0 ? 2e-3 : -2e-3;
        poses[k] = best * TypeParam::exp(step);
        EXPECT_GT(cost_of(poses, disagreeing, options), result.last_cost) << k << ' ' << axis;
      }
      poses[k] = best;
    }
  }
}

TYPED_TEST(PoseGraph, FixedAndUnconstrainedPosesStay) {
  Random random(4);
  std::vector<TypeParam> start = disturbed(this->ground_truth, 0.1, random);
  start.push_back(start[3] * start[5]);  // no edge constrains it
  std::vector<std::uint8_t> fixed(start.size(), 1);
  for (std::size_t k = 20; k < fixed.size(); ++k) fixed[k] = 0;
  std::vector<TypeParam> poses = start;
  optimize_pose_graph(poses, this->edges, fixed, this->options(LoopModel::robust));
  for (std::size_t k = 0; k < poses.size(); ++k)
    EXPECT_EQ(same_bytes(poses[k], start[k]), k < 20 || k + 1 == poses.size()) << k;
}

TYPED_TEST(PoseGraph, EdgesBetweenFixedPosesAreSkipped) {
  std::vector<std::uint8_t> fixed(this->ground_truth.size(), 1);
  fixed[20] = fixed[21] = 0;
  for (Constraint& edge : this->edges) {
    edge.weight = -1.0;
    const bool between =
        fixed[static_cast<std::size_t>(edge.from)] != 0 && fixed[static_cast<std::size_t>(edge.to)] != 0;
    if (between) edge.information.setZero();  // otherwise it would be refused
  }
  std::vector<TypeParam> poses = this->ground_truth;
  poses[20] = poses[19];
  const PoseGraphResult result = optimize_pose_graph(poses, this->edges, fixed, {});
  EXPECT_LT(result.last_cost, 1e-9);
  EXPECT_LT(worst_error(poses, this->ground_truth), 1e-5);
  int looked_at = 0;
  for (const Constraint& edge : this->edges) {
    const bool held = fixed[static_cast<std::size_t>(edge.from)] == 0 || fixed[static_cast<std::size_t>(edge.to)] == 0;
    EXPECT_EQ(edge.weight, held ? 1.0 : -1.0) << edge.from << ' ' << edge.to;
    looked_at += held ? 1 : 0;
  }
  EXPECT_GE(looked_at, 3);
}

TYPED_TEST(PoseGraph, NothingToDoIsDone) {
  std::vector<TypeParam> none, poses = this->ground_truth;
  EXPECT_TRUE(optimize_pose_graph(none, {}, {}, {}).converged);
  poses[1] = poses[7];
  const std::vector<std::uint8_t> all_fixed(poses.size(), 1);
  for (const PoseGraphResult& result : {optimize_pose_graph(poses, this->edges, all_fixed, {}),
                                        optimize_pose_graph(poses, {}, only_first(poses), {})}) {
    EXPECT_TRUE(result.converged);
    EXPECT_EQ(result.first_cost, 0.0);
    EXPECT_EQ(result.last_cost, 0.0);
  }
  EXPECT_TRUE(same_bytes(poses[1], this->ground_truth[7]));
}

TYPED_TEST(PoseGraph, ItStopsAfterTheIterationsAskedFor) {
  Random random(7);
  const std::vector<TypeParam> start = disturbed(this->ground_truth, 0.15, random);
  double last = 0.0;
  for (const int iterations : {50, 3, 2, 1}) {
    PoseGraphOptions options = this->options(LoopModel::trusted);
    options.iterations = iterations;
    std::vector<TypeParam> poses = start;
    const PoseGraphResult result = optimize_pose_graph(poses, this->edges, only_first(poses), options);
    EXPECT_EQ(result.converged, iterations == 50);
    EXPECT_GT(result.last_cost, last);
    last = result.last_cost;
  }
}

TYPED_TEST(PoseGraph, SameBytesTwice) {
  Random random(6);
  const std::vector<TypeParam> start = disturbed(this->ground_truth, 0.15, random);
  for (const LoopModel loops : {LoopModel::switchable, LoopModel::robust, LoopModel::trusted}) {
    std::vector<TypeParam> first = start, second = start;
    std::vector<Constraint> again = this->edges;
    optimize_pose_graph(first, this->edges, only_first(first), this->options(loops));
    optimize_pose_graph(second, again, only_first(second), this->options(loops));
    for (std::size_t k = 0; k < start.size(); ++k) {
      EXPECT_TRUE(same_bytes(first[k], second[k])) << k;
      EXPECT_EQ(same_bytes(first[k], start[k]), k == 0) << k;
    }
    for (std::size_t e = 0; e < again.size(); ++e) EXPECT_EQ(again[e].weight, this->edges[e].weight) << e;
  }
}

TYPED_TEST(PoseGraph, AnInvalidGraphIsRefused) {
  std::vector<TypeParam> poses = this->ground_truth;
  const auto refused = [&](Constraint edge) {
    std::vector<Constraint> one{edge};
    EXPECT_THROW(optimize_pose_graph(poses, one, only_first(poses), {}), Fault);
  };
  const auto last = static_cast<KeyframeId>(poses.size()) - 1;
  Constraint edge = edge_between(this->ground_truth, 0, poses.size() - 1, ConstraintKind::odometry);
  edge.to = last + 1;
  refused(edge);
  edge.to = last;
  edge.from = -1;
  refused(edge);
  edge.from = last;
  refused(edge);
  edge.from = 0;
  edge.information(5, 5) = -1.0;
  refused(edge);
  EXPECT_THROW(optimize_pose_graph(poses, this->edges, std::vector<std::uint8_t>(3, 0), {}), Fault);
  EXPECT_EQ(worst_error(poses, this->ground_truth), worst_error(this->ground_truth, this->ground_truth));
}

}  // namespace
}  // namespace rastro
