// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/math/lie.h"
#include "rastro/optimize/right_jacobian_inverse.h"
#include "rastro/optimize/sparse_solver.h"

namespace rastro {
namespace {

/// x y z, then qx qy qz qw.
using PoseValues = Eigen::Matrix<double, 7, 1>;

PoseValues values_of(const SE3& pose) {
  PoseValues values;
  values << pose.translation(), pose.rotation().quaternion().coeffs();
  return values;
}

SE3 pose_of(const double* values) {
  return {SO3(Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(values + 3))),
          Eigen::Map<const Eigen::Vector3d>(values)};
}

/// Steps pose * exp(d). Cost functions give their derivative by d in the first six columns, which this passes on.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* pose, const double* step, double* moved) const override {
    Eigen::Map<PoseValues> result(moved);
    result = values_of(pose_of(pose) * SE3::exp(Eigen::Map<const Vector6d>(step)));
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> by_step(jacobian);
    by_step.setIdentity();
    return true;
  }
  bool Minus(const double* to, const double* from, double* step) const override {
    Eigen::Map<Vector6d> result(step);
    result = (pose_of(from).inverse() * pose_of(to)).log();
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> by_pose(jacobian);
    by_pose.setIdentity();
    return true;
  }
};

/// Upper triangular U with U^T U = information.
Matrix6d root_of(const Matrix6d& information) {
  const Eigen::LLT<Matrix6d> root(0.5 * (information + information.transpose()));
  RASTRO_CHECK(root.info() == Eigen::Success, "an edge knows something of every direction");
  return root.matrixU();
}

class EdgeCost final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  explicit EdgeCost(const Constraint& edge) : root_(root_of(edge.information)), to_from_from_(edge.rigid().inverse()) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    const SE3 from_from_to = pose_of(poses[0]).inverse() * pose_of(poses[1]);
    const Vector6d error = (to_from_from_ * from_from_to).log();
    Eigen::Map<Vector6d> weighted(residuals);
    weighted = root_ * error;
    if (!jacobians) return true;
    const Matrix6d by_to = root_ * right_jacobian_inverse<SE3>(error);
    if (jacobians[0]) write(-by_to * from_from_to.inverse().adjoint(), jacobians[0]);
    if (jacobians[1]) write(by_to, jacobians[1]);
    return true;
  }

 private:
  static void write(const Matrix6d& by_step, double* jacobian) {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> target(jacobian);
    target.leftCols<6>() = by_step;
    target.col(6).setZero();
  }

  Matrix6d root_;
  SE3 to_from_from_;
};

/// What is left of s^2 e + price (1 - s)^2 with the best switch s = price / (price + e).
class SwitchLoss final : public ceres::LossFunction {
 public:
  explicit SwitchLoss(double price) : price_(price) {}
  void Evaluate(double squared, double out[3]) const override {
    const double open = price_ / (price_ + squared);
    out[0] = open * squared;
    out[1] = open * open;
    out[2] = -2.0 * open * open / (price_ + squared);
  }

 private:
  double price_;
};

/// One optimisation, stage by stage.
class Graph {
 public:
  Graph(std::vector<SE3>& poses, std::span<Constraint> edges, std::span<const std::uint8_t> fixed,
        const PoseGraphOptions& options)
      : poses_(poses), fixed_(fixed), options_(options) {
    for (Constraint& edge : edges) {
      if (!is_fixed(edge.from) || !is_fixed(edge.to)) edges_.push_back(&edge);
    }
    for (const SE3& pose : poses) values_.push_back(values_of(pose));
  }

  PoseGraphResult run() {
    if (edges_.empty()) return {true, 0.0, 0.0};
    PoseGraphResult result;
    bool first = true;
    for (const double price : prices()) {
      const ceres::Solver::Summary summary = solve(price);
      if (first) result.first_cost = summary.initial_cost;
      first = false;
      result.last_cost = summary.final_cost;
      result.converged = summary.termination_type == ceres::CONVERGENCE;
      if (!summary.IsSolutionUsable()) break;
      for (std::size_t i = 0; i < poses_.size(); ++i) {
        if (!is_fixed(static_cast<std::int64_t>(i))) poses_[i] = pose_of(values_[i].data());
      }
    }
    set_weights();
    return result;
  }

 private:
  bool is_fixed(std::int64_t pose) const { return fixed_[static_cast<std::size_t>(pose)] != 0; }
  SE3& pose(std::int64_t id) { return poses_[static_cast<std::size_t>(id)]; }
  double error_of(const Constraint& edge) { return squared_sigmas(edge, pose(edge.from), pose(edge.to)); }
  bool may_be_wrong(const Constraint& edge) const {
    return edge.kind != ConstraintKind::odometry && options_.loops != LoopModel::trusted;
  }

  /// From one at which no edge is yet turned off down to the one asked for.
  std::vector<double> prices() {
    std::vector<double> prices{options_.switch_price};
    if (options_.loops != LoopModel::switchable) return prices;
    double worst = 0.0;
    for (const Constraint* edge : edges_) {
      if (may_be_wrong(*edge)) worst = std::max(worst, error_of(*edge));
    }
    constexpr double step = 10.0;
    constexpr std::size_t most = 8;
    while (prices.front() < worst && prices.size() < most) prices.insert(prices.begin(), step * prices.front());
    return prices;
  }

  ceres::LossFunction* loss_for(const Constraint& edge, double price) const {
    if (!may_be_wrong(edge)) return nullptr;
    if (options_.loops == LoopModel::switchable) return new SwitchLoss(price);
    return new ceres::CauchyLoss(options_.robust_width);
  }

  ceres::Solver::Summary solve(double price) {
    ceres::Problem::Options owners;
    owners.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(owners);
    PoseManifold manifold;
    for (const Constraint* edge : edges_) {
      for (const std::int64_t id : {edge->from, edge->to}) {
        double* values = values_[static_cast<std::size_t>(id)].data();
        if (problem.HasParameterBlock(values)) continue;
        problem.AddParameterBlock(values, 7, &manifold);
        if (is_fixed(id)) problem.SetParameterBlockConstant(values);
      }
      problem.AddResidualBlock(new EdgeCost(*edge), loss_for(*edge, price),
                               values_[static_cast<std::size_t>(edge->from)].data(),
                               values_[static_cast<std::size_t>(edge->to)].data());
    }
    ceres::Solver::Summary summary;
    ceres::Solve(sparse_solver(options_.iterations), &problem, &summary);
    return summary;
  }

  void set_weights() {
    for (Constraint* edge : edges_) {
      edge->weight = 1.0;
      if (!may_be_wrong(*edge)) continue;
      const double squared = error_of(*edge), width = options_.robust_width * options_.robust_width;
      const double open = options_.switch_price / (options_.switch_price + squared);
      edge->weight = options_.loops == LoopModel::switchable ? open * open : width / (width + squared);
    }
  }

  std::vector<SE3>& poses_;
  std::span<const std::uint8_t> fixed_;
  PoseGraphOptions options_;
  std::vector<Constraint*> edges_;
  std::vector<PoseValues> values_;
};

}  // namespace

PoseGraphResult optimize_pose_graph(std::vector<SE3>& world_from_pose, std::span<Constraint> edges,
                                    std::span<const std::uint8_t> fixed, const PoseGraphOptions& options) {
  RASTRO_CHECK(fixed.size() == world_from_pose.size(), "every pose is fixed or free");
  return Graph(world_from_pose, edges, fixed, options).run();
}

Vector6d pose_edge_error(const Constraint& edge, const SE3& world_from_from, const SE3& world_from_to) {
  return (edge.rigid().inverse() * world_from_from.inverse() * world_from_to).log();
}

double squared_sigmas(const Constraint& edge, const SE3& world_from_from, const SE3& world_from_to) {
  const Vector6d error = pose_edge_error(edge, world_from_from, world_from_to);
  return error.dot(edge.information * error);
}

}  // namespace rastro
