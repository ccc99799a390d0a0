// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/similarity_graph.h"

#include <ceres/ceres.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/math/lie.h"
#include "rastro/optimize/right_jacobian_inverse.h"
#include "rastro/optimize/sparse_solver.h"

namespace rastro {
namespace {

/// x y z, qx qy qz qw, scale.
using PoseValues = Eigen::Matrix<double, 8, 1>;

PoseValues values_of(const Sim3& pose) {
  PoseValues values;
  values << pose.translation(), pose.rotation().quaternion().coeffs(), pose.scale();
  return values;
}

Sim3 pose_of(const double* values) {
  return {values[7], SO3(Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(values + 3))),
          Eigen::Map<const Eigen::Vector3d>(values)};
}

/// Steps pose * exp(d), with or without the scale. Cost functions give their derivative by d in the first columns,
/// which this passes on.
class SimilarityManifold final : public ceres::Manifold {
 public:
  explicit SimilarityManifold(bool fix_scale) : size_(fix_scale ? 6 : 7) {}
  int AmbientSize() const override { return 8; }
  int TangentSize() const override { return size_; }
  bool Plus(const double* pose, const double* step, double* moved) const override {
    Vector7d tangent = Vector7d::Zero();
    for (int k = 0; k < size_; ++k) tangent[k] = step[k];
    if (!(std::abs(tangent[6]) < 50.0) || !tangent.allFinite()) return false;
    Eigen::Map<PoseValues> result(moved);
    result = values_of(pose_of(pose) * Sim3::exp(tangent));
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> by_step(jacobian, 8, size_);
    by_step.setIdentity();
    return true;
  }
  bool Minus(const double* to, const double* from, double* step) const override {
    const Vector7d tangent = (pose_of(from).inverse() * pose_of(to)).log();
    for (int k = 0; k < size_; ++k) step[k] = tangent[k];
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> by_pose(jacobian, size_, 8);
    by_pose.setIdentity();
    return true;
  }

 private:
  int size_;
};

class EdgeCost final : public ceres::SizedCostFunction<7, 8, 8> {
 public:
  explicit EdgeCost(const SimilarityEdge& edge)
      : root_(std::sqrt(edge.weight)), to_from_from_(edge.from_from_to.inverse()) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    if (!(poses[0][7] > 0.0) || !(poses[1][7] > 0.0)) return false;
    const Sim3 from_from_to = pose_of(poses[0]).inverse() * pose_of(poses[1]);
    const Vector7d error = (to_from_from_ * from_from_to).log();
    Eigen::Map<Vector7d> weighted(residuals);
    weighted = root_ * error;
    if (!jacobians) return error.allFinite();
    const Matrix7d by_to = root_ * right_jacobian_inverse<Sim3>(error);
    if (jacobians[0]) write(-by_to * from_from_to.inverse().adjoint(), jacobians[0]);
    if (jacobians[1]) write(by_to, jacobians[1]);
    return by_to.allFinite();
  }

 private:
  static void write(const Matrix7d& by_step, double* jacobian) {
    Eigen::Map<Eigen::Matrix<double, 7, 8, Eigen::RowMajor>> target(jacobian);
    target.leftCols<7>() = by_step;
    target.col(7).setZero();
  }

  double root_;
  Sim3 to_from_from_;
};

}  // namespace

SimilarityGraphResult optimize_similarity_graph(std::vector<Sim3>& world_from_pose,
                                                std::span<const SimilarityEdge> edges,
                                                std::span<const std::uint8_t> fixed,
                                                const SimilarityGraphOptions& options) {
  RASTRO_CHECK(fixed.size() == world_from_pose.size(), "every pose is fixed or free");
  std::vector<PoseValues> values;
  for (const Sim3& pose : world_from_pose) values.push_back(values_of(pose));
  SimilarityManifold manifold(options.fix_scale);
  ceres::Problem::Options owners;
  owners.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(owners);
  for (const SimilarityEdge& edge : edges) {
    RASTRO_CHECK(edge.from < fixed.size() && edge.to < fixed.size(), "an edge is between poses of the graph");
    if (fixed[edge.from] != 0 && fixed[edge.to] != 0) continue;
    for (const std::uint32_t id : {edge.from, edge.to}) {
      double* pose = values[id].data();
      if (problem.HasParameterBlock(pose)) continue;
      problem.AddParameterBlock(pose, 8, &manifold);
      if (fixed[id] != 0) problem.SetParameterBlockConstant(pose);
    }
    problem.AddResidualBlock(new EdgeCost(edge), nullptr, values[edge.from].data(), values[edge.to].data());
  }
  if (problem.NumResidualBlocks() == 0) return {true, 0.0, 0.0};
  ceres::Solver::Summary summary;
  ceres::Solve(sparse_solver(options.iterations), &problem, &summary);
  const SimilarityGraphResult result{summary.termination_type == ceres::CONVERGENCE, summary.initial_cost,
                                     summary.final_cost};
  if (!summary.IsSolutionUsable()) return result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (fixed[i] == 0 && problem.HasParameterBlock(values[i].data())) world_from_pose[i] = pose_of(values[i].data());
  }
  return result;
}

}  // namespace rastro
