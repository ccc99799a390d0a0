// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/pose_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rastro/optimize/pose_graph_testing.h"

namespace rastro {
namespace {

using testing::disturbed;
using testing::edge_between;
using testing::loop_edges;
using testing::only_first;
using testing::random_tangent;
using testing::square_loop;
using testing::worst_error;

template <typename Pose>
class PoseSpaces : public ::testing::Test {
 protected:
  static Pose random_pose(Random& random) { return Pose::exp(random_tangent<Pose>(0.8, random)); }
};
TYPED_TEST_SUITE(PoseSpaces, testing::GraphPoses);

TYPED_TEST(PoseSpaces, StepsAndValuesConvertBothWays) {
  using Space = PoseSpace<TypeParam>;
  Random random(1);
  for (int k = 0; k < 20; ++k) {
    const TypeParam pose = this->random_pose(random);
    const typename TypeParam::Tangent step = random_tangent<TypeParam>(0.5, random);
    const typename Space::Values values = Space::values_of(pose), moved = Space::step(values, step);
    EXPECT_LT((Space::pose_of(values).matrix() - pose.matrix()).norm(), 1e-12);
    EXPECT_LT((Space::difference(values, moved) - step).norm(), 1e-9);
    EXPECT_GT((Space::pose_of(moved).matrix() - pose.matrix()).norm(), 1e-3);
  }
}

TEST(PoseSpaceOfSim3, NoStepMakesTheScaleZero) {
  const Sim3 pose(2.0, SO3::exp({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0});
  for (const double grown : {-1e6, -49.0, 49.0, 1e6}) {
    const Vector7d step = Vector7d::Constant(grown);
    const auto moved = PoseSpace<Sim3>::step(PoseSpace<Sim3>::values_of(pose), step);
    EXPECT_NEAR(std::log(moved[7] / 2.0), std::clamp(grown, -50.0, 50.0), 1e-9);
    EXPECT_TRUE(PoseSpace<Sim3>::pose_of(moved).matrix().allFinite());
  }
}

TYPED_TEST(PoseSpaces, DerivativesAreThoseOfFiniteDifferences) {
  using Space = PoseSpace<TypeParam>;
  constexpr int dimension = Space::dimension;
  Random random(2);
  // For small errors a series is used.
  for (const double error : {0.03, 0.5}) {
    const TypeParam from = this->random_pose(random), to = this->random_pose(random);
    const TypeParam relative = from.inverse() * to * TypeParam::exp(random_tangent<TypeParam>(error, random));
    const typename Space::Values at_from = Space::values_of(from), at_to = Space::values_of(to);
    const typename Space::Edge edge(relative);
    const auto residual_at = [&](const auto& a, const auto& b) { return edge.linearize(a, b, false).residual; };
    const LinearizedEdge<dimension> linearized = edge.linearize(at_from, at_to, true);
    EXPECT_LT((linearized.residual - Space::residual(relative.inverse() * from.inverse() * to)).norm(), 1e-12);
    EXPECT_EQ(linearized.residual, residual_at(at_from, at_to));
    const Eigen::Matrix<double, dimension, dimension> by_from = linearized.by_to * linearized.to_by_from;
    constexpr double h = 1e-6;
    for (int axis = 0; axis < dimension; ++axis) {
      typename TypeParam::Tangent step = TypeParam::Tangent::Zero();
      step[axis] = h;
      const auto by = [&](const auto& ahead, const auto& back) { return ((ahead - back) / (2.0 * h)).eval(); };
      const auto numeric_to =
          by(residual_at(at_from, Space::step(at_to, step)), residual_at(at_from, Space::step(at_to, -step)));
      const auto numeric_from =
          by(residual_at(Space::step(at_from, step), at_to), residual_at(Space::step(at_from, -step), at_to));
      EXPECT_LT((linearized.by_to.col(axis) - numeric_to).norm(), 1e-7) << error << ' ' << axis;
      EXPECT_LT((by_from.col(axis) - numeric_from).norm(), 1e-7) << error << ' ' << axis;
    }
  }
}

TYPED_TEST(PoseSpaces, ResidualIsTheErrorAtTheEndOfTheEdge) {
  const std::vector<TypeParam> ground_truth = square_loop<TypeParam>();
  Constraint edge = edge_between(ground_truth, 2, 9, ConstraintKind::loop);
  edge.scale_variance = 0.002;
  PoseGraphOptions options;
  options.scale_information = 700.0;
  EXPECT_LT(edge_residual(edge, ground_truth[2], ground_truth[9]).norm(), 1e-12);
  typename TypeParam::Tangent off = TypeParam::Tangent::Zero();
  // Along one axis, where the logarithm and x, y, yaw are equal.
  for (int axis = 0; axis < TypeParam::Tangent::RowsAtCompileTime; ++axis) {
    off.setZero();
    off[axis] = axis % 2 == 0 ? 0.1 : -0.2;
    EXPECT_LT((edge_residual(edge, ground_truth[2], ground_truth[9] * TypeParam::exp(off)) - off).norm(), 1e-12)
        << axis;
    const int full = TypeParam::Tangent::RowsAtCompileTime == 3 && axis == 2 ? 5 : axis;
    const double information = full < 6 ? edge.information(full, full) : 1.0 / (1.0 / 700.0 + 0.002);
    EXPECT_NEAR(squared_sigmas(edge, ground_truth[2], ground_truth[9] * TypeParam::exp(off), options),
                information * off[axis] * off[axis], 1e-6)
        << axis;
  }
}

TEST(PoseSpaceOfSE3, ResidualIsATangentVector) {
  const std::vector<SE3> ground_truth = square_loop<SE3>();
  const Constraint edge = edge_between(ground_truth, 2, 9, ConstraintKind::loop);
  Vector6d off;
  off << 0.1, -0.2, 0.3, 0.04, -0.05, 0.06;
  EXPECT_LT((edge_residual(edge, ground_truth[2], ground_truth[9] * SE3::exp(off)) - off).norm(), 1e-12);
  EXPECT_NEAR(squared_sigmas(edge, ground_truth[2], ground_truth[9] * SE3::exp(off)), off.dot(edge.information * off),
              1e-6);
}

TEST(PoseSpaceOfSE2, ResidualIsXYAndYawInTheAxesOfTheEnd) {
  const SE2 from(SO2::from_angle(M_PI / 2.0), {4.0, -1.0}), relative(SO2::from_angle(3.0), {2.0, 1.0});
  // Also across the wrap-around of angles.
  const SE2 rest(SO2::from_angle(0.3), {0.1, -0.2});
  Constraint edge = planar_constraint(0, 1, relative, Eigen::Vector3d(100.0, 25.0, 1e4).asDiagonal(), {});
  const Eigen::Vector3d residual = edge_residual(edge, from, from * relative * rest);
  EXPECT_LT((residual - Eigen::Vector3d(0.1, -0.2, 0.3)).norm(), 1e-12);
  // The information is in the axes of `from`.
  const Eigen::Vector2d off = relative.rotation() * rest.translation();
  EXPECT_NEAR(squared_sigmas(edge, from, from * relative * rest),
              100.0 * off.x() * off.x() + 25.0 * off.y() * off.y() + 1e4 * 0.09, 1e-9);
  // Components outside the plane are ignored.
  edge.information.row(2) += Vector6d::Constant(7.0).transpose();
  edge.information(3, 4) = edge.information(4, 0) = 1e3;
  EXPECT_NEAR(squared_sigmas(edge, from, from * relative), 0.0, 1e-20);
  EXPECT_LT((edge_residual(edge, from, from * relative * rest) - residual).norm(), 1e-15);
}

TEST(PoseSpaceOfSE2, TheSameGraphInSpaceHasTheSamePoses) {
  // Exact edges: x, y, yaw and the logarithm have the same zero, whatever the start.
  const std::vector<SE2> ground_truth = square_loop<SE2>();
  std::vector<Constraint> edges = loop_edges(ground_truth);
  for (Constraint& edge : edges)
    edge = planar_constraint(edge.from, edge.to, in_plane(edge.rigid()), in_plane(edge.information), edge.kind);
  // Small inconsistencies: the two differ by their square.
  for (std::size_t e = 0; e < edges.size(); ++e)
    edges[e].from_from_to = edges[e].from_from_to * Sim3(in_space(SE2::exp({e % 2 == 0 ? 1e-3 : -1e-3, 1e-3, -1e-3})));
  Random random(8);
  std::vector<SE2> poses = disturbed(ground_truth, 0.1, random);
  std::vector<SE3> in_space_poses;
  for (const SE2& pose : poses) in_space_poses.push_back(in_space(pose));
  const PoseGraphOptions options{.loops = LoopModel::trusted, .iterations = 100};
  optimize_pose_graph(poses, edges, only_first(poses), options);
  optimize_pose_graph(in_space_poses, edges, only_first(poses), options);
  EXPECT_GT(worst_error(poses, ground_truth), 1e-3);
  for (std::size_t k = 0; k < poses.size(); ++k)
    EXPECT_LT((in_space(poses[k]).inverse() * in_space_poses[k]).log().norm(), 2e-5) << k;
}

/// Each step is 1 % longer than the previous one in the unit of the first; the last pose observes the first with the
/// correct scale.
struct DriftOfScale {
  std::vector<Sim3> ground_truth, poses;
  std::vector<Constraint> edges;

  DriftOfScale() {
    for (int k = 0; k < 40; ++k) {
      const double angle = 2.0 * M_PI * k / 40.0;
      ground_truth.emplace_back(1.0, SO3::exp({0.0, 0.1, angle}),
                                Eigen::Vector3d(5.0 * std::sin(angle), 5.0 * std::cos(angle), 0.1 * k));
    }
    poses.push_back(ground_truth[0]);
    for (std::size_t k = 0; k + 1 < ground_truth.size(); ++k) {
      const Sim3 step = ground_truth[k].inverse() * ground_truth[k + 1] * Sim3(1.01, SO3(), Eigen::Vector3d::Zero());
      poses.push_back(poses.back() * step);
      edges.push_back(edge(k, k + 1, step));
    }
    edges.push_back(edge(ground_truth.size() - 1, 0, ground_truth.back().inverse() * ground_truth[0]));
  }
  static Constraint edge(std::size_t from, std::size_t to, const Sim3& from_from_to) {
    return {.from = static_cast<KeyframeId>(from), .to = static_cast<KeyframeId>(to), .from_from_to = from_from_to};
  }
};

TEST(PoseSpaceOfSim3, ALoopRemovesTheScaleDrift) {
  DriftOfScale drift;
  std::vector<Sim3> poses = drift.poses;
  ASSERT_GT(poses.back().scale(), 1.45);
  PoseGraphOptions options{.iterations = 100};
  optimize_pose_graph(poses, drift.edges, only_first(poses), options);
  EXPECT_NEAR(poses.back().scale(), 1.0, 0.02);
  EXPECT_LT((poses.back().translation() - drift.ground_truth.back().translation()).norm(), 0.2);
  // The loop's scale error is now spread over all.
  EXPECT_NEAR(poses[20].scale(), 1.0, 0.05);
}

TEST(PoseSpaceOfSim3, KnownScalesStay) {
  DriftOfScale drift;
  Random random(2);
  for (Constraint& edge : drift.edges) testing::falsify(edge, Sim3::exp(random_tangent<Sim3>(0.1, random)));
  const PoseGraphOptions options{.iterations = 300, .fix_scale = true};
  std::vector<Sim3> poses = drift.poses;
  const PoseGraphResult result = optimize_pose_graph(poses, drift.edges, only_first(poses), options);
  EXPECT_NEAR(result.last_cost, testing::cost_of(poses, drift.edges, options), 1e-6 * result.last_cost);
  for (std::size_t k = 1; k < poses.size(); k += 3) {
    EXPECT_NEAR(poses[k].scale(), drift.poses[k].scale(), 1e-12);
    for (int axis = 0; axis < 12; ++axis) {
      std::vector<Sim3> other = poses;
      Vector7d step = Vector7d::Zero();
      step[axis / 2] = axis % 2 == 0 ? 2e-3 : -2e-3;
      other[k] = poses[k] * Sim3::exp(step);
      EXPECT_GT(testing::cost_of(other, drift.edges, options), result.last_cost) << k << ' ' << axis;
    }
  }
}

TEST(PoseSpaceOfSim3, WithScalesOfOneItIsThatOfSE3) {
  Random random(9);
  const std::vector<SE3> ground_truth = square_loop<SE3>(), start = disturbed(ground_truth, 0.1, random);
  std::vector<Constraint> edges = loop_edges(ground_truth);
  for (Constraint& edge : edges) testing::falsify(edge, SE3::exp(random_tangent<SE3>(0.02, random)));
  std::vector<SE3> rigid = start;
  std::vector<Sim3> similar(start.begin(), start.end());
  const PoseGraphOptions options{.iterations = 100, .fix_scale = true};
  const PoseGraphResult of_rigid = optimize_pose_graph(rigid, edges, only_first(rigid), options);
  const PoseGraphResult of_similar = optimize_pose_graph(similar, edges, only_first(rigid), options);
  EXPECT_NEAR(of_similar.last_cost, of_rigid.last_cost, 1e-9 * of_rigid.last_cost);
  for (std::size_t k = 0; k < rigid.size(); ++k)
    EXPECT_LT((Sim3(rigid[k]).inverse() * similar[k]).log().norm(), 1e-8) << k;
}

TEST(PoseSpaceOfSim3, ScaleHasTheGivenInformation) {
  // Two edges of equal weight disagree about the scale only: the result is in the middle.
  for (const double information : {1.0, 100.0}) {
    std::vector<Constraint> edges(2, DriftOfScale::edge(0, 1, Sim3()));
    edges[1].from_from_to = Sim3(2.0, SO3(), {1.0, 0.0, 0.0});
    std::vector<Sim3> poses(2);
    const PoseGraphOptions options{.iterations = 100, .scale_information = information};
    const PoseGraphResult result = optimize_pose_graph(poses, edges, only_first(poses), options);
    EXPECT_NEAR(result.last_cost, testing::cost_of(poses, edges, options), 1e-9);
    EXPECT_NEAR(result.first_cost, 0.5 * squared_sigmas(edges[1], Sim3(), Sim3(), options), 1e-9);
    EXPECT_NEAR(std::log(poses[1].scale()), 0.5 * std::log(2.0), information > 10.0 ? 0.01 : 0.1);
  }
}

}  // namespace
}  // namespace rastro
