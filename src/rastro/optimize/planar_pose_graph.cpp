// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/planar_pose_graph.h"

#include <ceres/ceres.h>

#include <cmath>

#include "rastro/optimize/sparse_solver.h"

namespace rastro {
namespace {

/// Error of an edge with its derivatives by both poses (x, y, angle).
class EdgeCost : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  explicit EdgeCost(const PlanarEdge& edge)
      : root_(edge.root_information), shift_(edge.a_from_b.translation()), turn_(edge.a_from_b.rotation().angle()) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    const double *a = poses[0], *b = poses[1];
    const double c = std::cos(a[2]), s = std::sin(a[2]);
    const Eigen::Vector2d between(b[0] - a[0], b[1] - a[1]);
    const Eigen::Vector2d seen(c * between.x() + s * between.y(), -s * between.x() + c * between.y());
    const Eigen::Vector3d error(seen.x() - shift_.x(), seen.y() - shift_.y(),
                                std::remainder(b[2] - a[2] - turn_, 2.0 * M_PI));
    Eigen::Map<Eigen::Vector3d> weighted(residuals);
    weighted = root_ * error;
    if (!jacobians) return true;
    using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    Eigen::Matrix3d by_b = Eigen::Matrix3d::Identity();
    by_b.topLeftCorner<2, 2>() << c, s, -s, c;
    if (jacobians[0]) {
      Eigen::Matrix3d by_a = -by_b;
      by_a.topRightCorner<2, 1>() = Eigen::Vector2d(seen.y(), -seen.x());
      Eigen::Map<RowMajor> weighted_by_a(jacobians[0]);
      weighted_by_a = root_ * by_a;
    }
    if (jacobians[1]) {
      Eigen::Map<RowMajor> weighted_by_b(jacobians[1]);
      weighted_by_b = root_ * by_b;
    }
    return true;
  }

 private:
  Eigen::Matrix3d root_;
  Eigen::Vector2d shift_;
  double turn_;
};

}  // namespace

PlanarPoseGraphResult optimize_planar_pose_graph(std::vector<SE2>& world_from_pose,
                                                 const std::vector<PlanarEdge>& edges,
                                                 const PlanarPoseGraphOptions& options) {
  if (world_from_pose.empty() || edges.empty()) return {true, 0.0, 0.0};
  std::vector<Eigen::Vector3d> values;
  for (const SE2& pose : world_from_pose)
    values.emplace_back(pose.translation().x(), pose.translation().y(), pose.rotation().angle());
  ceres::Problem problem;
  for (const PlanarEdge& edge : edges) {
    ceres::LossFunction* loss = edge.robust ? new ceres::CauchyLoss(options.robust_width) : nullptr;
    problem.AddResidualBlock(new EdgeCost(edge), loss, values[edge.a].data(), values[edge.b].data());
  }
  if (problem.HasParameterBlock(values[0].data())) problem.SetParameterBlockConstant(values[0].data());
  ceres::Solver::Summary summary;
  ceres::Solve(sparse_solver(options.iterations), &problem, &summary);
  if (summary.IsSolutionUsable()) {
    for (std::size_t i = 0; i < values.size(); ++i)
      world_from_pose[i] = SE2(SO2::from_angle(values[i].z()), values[i].head<2>());
  }
  return {summary.termination_type == ceres::CONVERGENCE, summary.initial_cost, summary.final_cost};
}

Eigen::Vector3d planar_edge_error(const PlanarEdge& edge, const SE2& world_from_a, const SE2& world_from_b) {
  const SE2 a_from_b = world_from_a.inverse() * world_from_b;
  Eigen::Vector3d error;
  error << a_from_b.translation() - edge.a_from_b.translation(),
      (edge.a_from_b.rotation().inverse() * a_from_b.rotation()).angle();
  return edge.root_information * error;
}

}  // namespace rastro
