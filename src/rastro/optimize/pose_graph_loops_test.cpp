// SPDX-License-Identifier: Apache-2.0
// What is done about edges that may be wrong.
#include <gtest/gtest.h>

#include "rastro/optimize/pose_graph.h"
#include "rastro/optimize/pose_graph_testing.h"

namespace rastro {
namespace {

using testing::edge_between;
using testing::loop_edges;
using testing::only_first;
using testing::square_loop;
using testing::worst_error;

template <typename Pose>
class LoopsOfPoseGraph : public ::testing::Test {
 protected:
  using Tangent = typename Pose::Tangent;

  LoopsOfPoseGraph() {
    options.iterations = 50;
    options.scale_information = 700.0;
  }

  /// A motion of a given size; in space and with scales along the other axes, too.
  static Pose wrong_by(double size) {
    Tangent by = Tangent::Constant(0.2 * size);
    by[0] = size;
    return Pose::exp(by);
  }

  /// From odometry alone, which bends: the end is far off, and so are correct loops.
  std::vector<Pose> drifted() const {
    Tangent bend = Tangent::Constant(0.001);
    bend[0] = 0.01;
    bend[1] = 0.005;
    bend[Tangent::RowsAtCompileTime == 3 ? 2 : 5] = 0.01;
    std::vector<Pose> poses{ground_truth[0]};
    for (std::size_t k = 1; k < ground_truth.size(); ++k)
      poses.push_back(poses.back() * (ground_truth[k - 1].inverse() * ground_truth[k]) * Pose::exp(bend));
    return poses;
  }

  /// Two poses: odometry that they are equal, and a loop that is `sigmas` off, whatever its weight.
  std::vector<Constraint> two_poses(double sigmas) const {
    const std::vector<Pose> same(2);
    std::vector<Constraint> edges{edge_between(same, 0, 1, ConstraintKind::odometry),
                                  edge_between(same, 0, 1, ConstraintKind::loop)};
    for (Constraint& edge : edges) edge.information.setIdentity();
    edges[1].from_from_to = Sim3(SE3(SO3(), {sigmas, 0.0, 0.0}));
    return edges;
  }

  const std::vector<Pose> ground_truth = square_loop<Pose>();
  PoseGraphOptions options;
};
TYPED_TEST_SUITE(LoopsOfPoseGraph, testing::GraphPoses);

TYPED_TEST(LoopsOfPoseGraph, AWrongOneIsSwitchedOffAndCorrectOnesAfterALongDriftAreNot) {
  std::vector<Constraint> edges = loop_edges(this->ground_truth);
  edges.push_back(edge_between(this->ground_truth, 4, 25, ConstraintKind::loop));
  testing::falsify(edges.back(), this->wrong_by(1.5));
  std::vector<TypeParam> poses = this->drifted();
  ASSERT_GT((poses.back().translation() - this->ground_truth.back().translation()).norm(), 0.15);
  optimize_pose_graph(poses, edges, only_first(poses), this->options);
  EXPECT_LT(worst_error(poses, this->ground_truth), 0.03);
  EXPECT_LT(edges.back().weight, 0.01);
  for (std::size_t e = 0; e + 1 < edges.size(); ++e) EXPECT_GT(edges[e].weight, 0.9) << e;
  this->options.loops = LoopModel::trusted;
  optimize_pose_graph(poses, edges, only_first(poses), this->options);
  EXPECT_GT(worst_error(poses, this->ground_truth), 0.1) << "it must pull where it is believed";
  EXPECT_EQ(edges.back().weight, 1.0);
}

TYPED_TEST(LoopsOfPoseGraph, AWrongOneWithARobustKernelHasLittleInfluence) {
  std::vector<Constraint> edges = loop_edges(this->ground_truth);
  edges.push_back(edge_between(this->ground_truth, 4, 25, ConstraintKind::proximity));
  testing::falsify(edges.back(), this->wrong_by(3.0));
  std::vector<TypeParam> poses = this->ground_truth;
  this->options.loops = LoopModel::robust;
  this->options.robust_width = 2.0;
  optimize_pose_graph(poses, edges, only_first(poses), this->options);
  EXPECT_LT(worst_error(poses, this->ground_truth), 0.03);
  EXPECT_LT(edges.back().weight, 0.01);
  edges.back().kind = ConstraintKind::odometry;
  optimize_pose_graph(poses, edges, only_first(poses), this->options);
  EXPECT_GT(worst_error(poses, this->ground_truth), 0.3) << "odometry is believed";
}

TYPED_TEST(LoopsOfPoseGraph, WeightIsTheSlopeOfTheKernel) {
  for (const LoopModel loops : {LoopModel::switchable, LoopModel::robust, LoopModel::trusted}) {
    std::vector<Constraint> edges = this->two_poses(5.0);
    std::vector<TypeParam> poses(2);
    this->options = {.loops = loops, .switch_price = 20.0, .robust_width = 3.0, .iterations = 100};
    optimize_pose_graph(poses, edges, only_first(poses), this->options);
    const double squared = squared_sigmas(edges[1], poses[0], poses[1], this->options), step = 1e-4;
    ASSERT_GT(squared, 1.0);
    const double slope = (testing::kernel_cost(squared + step, edges[1], this->options) -
                          testing::kernel_cost(squared - step, edges[1], this->options)) /
                         (2.0 * step);
    EXPECT_NEAR(edges[1].weight, slope, 1e-6);
    EXPECT_EQ(edges[0].weight, 1.0);
    // At the equilibrium: x = weight * (5 - x).
    EXPECT_NEAR(poses[1].translation().x(), slope * (5.0 - poses[1].translation().x()), 1e-2);
  }
}

TYPED_TEST(LoopsOfPoseGraph, TheFirstStageSwitchesNothingOff) {
  // Half of the sum of squared sigmas in the first stage.
  const auto first_cost = [&](double price, double loop, double odometry) {
    std::vector<Constraint> edges = this->two_poses(loop);
    edges[0].from_from_to = Sim3(SE3(SO3(), {odometry, 0.0, 0.0}));
    std::vector<TypeParam> poses(2);
    this->options.switch_price = price;
    return optimize_pose_graph(poses, edges, only_first(poses), this->options).first_cost;
  };
  const auto with_price = [](double price, double squared) { return 0.5 * price * squared / (price + squared); };
  EXPECT_NEAR(first_cost(30.0, 5.0, 0.0), with_price(30.0, 25.0), 1e-9);
  EXPECT_NEAR(first_cost(25.0, 5.0, 0.0), with_price(25.0, 25.0), 1e-9) << "at its price it is not yet turned off";
  EXPECT_NEAR(first_cost(30.0, 6.0, 0.0), with_price(300.0, 36.0), 1e-9);
  EXPECT_NEAR(first_cost(30.0, 40.0, 0.0), with_price(3000.0, 1600.0), 1e-9);
  EXPECT_NEAR(first_cost(30.0, 5.0, 40.0), with_price(30.0, 25.0) + 800.0, 1e-9) << "odometry has no switch";
  const double far = 1e6 * 1e6;
  EXPECT_NEAR(first_cost(30.0, 1e6, 0.0), with_price(3e8, far), 1e-9 * far) << "there are at most 8 stages";
  this->options.gradual = false;
  EXPECT_NEAR(first_cost(30.0, 40.0, 0.0), with_price(30.0, 1600.0), 1e-9) << "the switches decide at once";
  this->options.loops = LoopModel::robust;
  const double width = this->options.robust_width * this->options.robust_width;
  EXPECT_NEAR(first_cost(30.0, 40.0, 0.0), 0.5 * width * std::log1p(1600.0 / width), 1e-9);
}

}  // namespace
}  // namespace rastro
