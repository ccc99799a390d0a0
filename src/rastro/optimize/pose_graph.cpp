// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/optimize/pose_space.h"
#include "rastro/optimize/switch_kernel.h"

namespace rastro {
namespace {

template <typename Pose>
constexpr int value_count = PoseSpace<Pose>::Values::RowsAtCompileTime;

template <typename Pose>
typename PoseSpace<Pose>::Values values_at(const double* values) {
  return Eigen::Map<const typename PoseSpace<Pose>::Values>(values);
}

/// Steps of the space, along its first axes. Cost functions return their derivatives by such a step in the first
/// columns, and this passes them on.
template <typename Pose>
class PoseManifold final : public ceres::Manifold {
 public:
  using Space = PoseSpace<Pose>;
  explicit PoseManifold(int axes) : axes_(axes) {}
  int AmbientSize() const override { return value_count<Pose>; }
  int TangentSize() const override { return axes_; }
  bool Plus(const double* pose, const double* step, double* moved) const override {
    typename Pose::Tangent by = Pose::Tangent::Zero();
    by.head(axes_) = Eigen::Map<const Eigen::VectorXd>(step, axes_);
    if (!by.allFinite()) return false;
    Eigen::Map<typename Space::Values> result(moved);
    result = Space::step(values_at<Pose>(pose), by);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<RowMajor>(jacobian, value_count<Pose>, axes_).setIdentity();
    return true;
  }
  bool Minus(const double* to, const double* from, double* step) const override {
    const auto by = Space::difference(values_at<Pose>(from), values_at<Pose>(to));
    Eigen::Map<Eigen::VectorXd>(step, axes_) = by.head(axes_);
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<RowMajor>(jacobian, axes_, value_count<Pose>).setIdentity();
    return true;
  }

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  int axes_;
};

/// Upper triangular U with U^T U = information.
template <typename Matrix>
Matrix root_of(const Matrix& information) {
  const Eigen::LLT<Matrix> root(0.5 * (information + information.transpose()));
  RASTRO_CHECK(root.info() == Eigen::Success, "an edge knows something of every direction");
  return root.matrixU();
}

/// Residual of an edge in sigmas.
template <typename Pose>
class EdgeCost final
    : public ceres::SizedCostFunction<PoseSpace<Pose>::dimension, value_count<Pose>, value_count<Pose>> {
 public:
  using Space = PoseSpace<Pose>;
  static constexpr int dimension = Space::dimension;
  using Matrix = Eigen::Matrix<double, dimension, dimension>;

  EdgeCost(const Constraint& edge, const PoseGraphOptions& options)
      : root_(root_of<Matrix>(Space::information(edge, options))), edge_(Space::relative(edge)) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    const LinearizedEdge<dimension> edge =
        edge_.linearize(values_at<Pose>(poses[0]), values_at<Pose>(poses[1]), jacobians != nullptr);
    Eigen::Map<typename Pose::Tangent> weighted(residuals);
    weighted = root_ * edge.residual;
    if (!jacobians) return weighted.allFinite();
    const Matrix by_to = root_ * edge.by_to;
    if (jacobians[0]) write(by_to * edge.to_by_from, jacobians[0]);
    if (jacobians[1]) write(by_to, jacobians[1]);
    return weighted.allFinite() && by_to.allFinite();
  }

 private:
  static void write(const Matrix& by_step, double* jacobian) {
    Eigen::Map<Eigen::Matrix<double, dimension, value_count<Pose>, Eigen::RowMajor>> target(jacobian);
    target.setZero();
    target.template leftCols<dimension>() = by_step;
  }

  Matrix root_;
  typename Space::Edge edge_;
};

class SwitchLoss final : public ceres::LossFunction {
 public:
  explicit SwitchLoss(double price) : kernel_{price} {}
  void Evaluate(double squared, double out[3]) const override {
    out[0] = kernel_.cost(squared);
    out[1] = kernel_.weight(squared);
    out[2] = kernel_.weight_slope(squared);
  }

 private:
  SwitchKernel kernel_;
};

/// Sparse, silent, and on one thread, so that results repeat.
ceres::Solver::Options sparse_solver(int iterations) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  if (!ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::SUITE_SPARSE))
    solver.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  solver.max_num_iterations = iterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

/// One optimization, stage by stage.
template <typename Pose>
class Graph {
 public:
  using Space = PoseSpace<Pose>;

  Graph(std::vector<Pose>& poses, std::span<Constraint> edges, std::span<const std::uint8_t> fixed,
        const PoseGraphOptions& options)
      : poses_(poses), fixed_(fixed), options_(options), moves_(poses.size(), 0) {
    for (Constraint& edge : edges) add(edge);
    for (const Pose& pose : poses) values_.push_back(Space::values_of(pose));
  }

  PoseGraphResult run() {
    if (edges_.empty()) return {true, 0.0, 0.0};
    PoseGraphResult result;
    const std::vector<double> prices = switch_prices();
    for (std::size_t stage = 0; stage < prices.size(); ++stage) {
      const ceres::Solver::Summary summary = solve(prices[stage]);
      if (stage == 0) result.first_cost = summary.initial_cost;
      result.last_cost = summary.final_cost;
      result.converged = summary.termination_type == ceres::CONVERGENCE;
      if (!summary.IsSolutionUsable()) break;
      for (std::size_t i = 0; i < poses_.size(); ++i) {
        if (moves_[i] != 0) poses_[i] = Space::pose_of(values_[i]);
      }
    }
    set_weights();
    return result;
  }

 private:
  static std::size_t at(KeyframeId id) { return static_cast<std::size_t>(id); }
  bool is_fixed(KeyframeId id) const { return fixed_[at(id)] != 0; }
  double error_of(const Constraint& edge) const {
    return squared_sigmas(edge, poses_[at(edge.from)], poses_[at(edge.to)], options_);
  }
  bool may_be_wrong(const Constraint& edge) const {
    return edge.kind != ConstraintKind::odometry && options_.loops != LoopModel::trusted;
  }

  void add(Constraint& edge) {
    for (const KeyframeId id : {edge.from, edge.to})
      RASTRO_CHECK(at(id) < poses_.size(), "an edge is between poses of the graph");  // a negative one becomes huge
    RASTRO_CHECK(edge.from != edge.to, "an edge is between two poses");
    if (is_fixed(edge.from) && is_fixed(edge.to)) return;
    edges_.push_back(&edge);
    for (const KeyframeId id : {edge.from, edge.to}) moves_[at(id)] = is_fixed(id) ? 0 : 1;
  }

  /// From one at which no edge is switched off yet down to the requested one.
  std::vector<double> switch_prices() const {
    std::vector<double> prices{options_.switch_price};
    if (options_.loops != LoopModel::switchable || !options_.gradual) return prices;
    double worst = 0.0;
    for (const Constraint* edge : edges_) {
      if (may_be_wrong(*edge)) worst = std::max(worst, error_of(*edge));
    }
    constexpr double step = 10.0;
    constexpr std::size_t most = 8;
    while (prices.front() < worst && prices.size() < most) prices.insert(prices.begin(), step * prices.front());
    return prices;
  }

  /// Null for a trusted edge.
  std::unique_ptr<ceres::LossFunction> loss_for(const Constraint& edge, double price) const {
    if (!may_be_wrong(edge)) return nullptr;
    if (options_.loops == LoopModel::switchable) return std::make_unique<SwitchLoss>(price);
    return std::make_unique<ceres::CauchyLoss>(options_.robust_width);
  }

  ceres::Solver::Summary solve(double price) {
    ceres::Problem::Options owners;
    owners.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(owners);
    PoseManifold<Pose> manifold(std::same_as<Pose, Sim3> && options_.fix_scale ? 6 : Space::dimension);
    for (const Constraint* edge : edges_) {
      for (const KeyframeId id : {edge->from, edge->to}) {
        double* values = values_[at(id)].data();
        if (problem.HasParameterBlock(values)) continue;
        problem.AddParameterBlock(values, value_count<Pose>, &manifold);
        if (is_fixed(id)) problem.SetParameterBlockConstant(values);
      }
      auto cost = std::make_unique<EdgeCost<Pose>>(*edge, options_);
      problem.AddResidualBlock(cost.release(), loss_for(*edge, price).release(), values_[at(edge->from)].data(),
                               values_[at(edge->to)].data());
    }
    ceres::Solver::Summary summary;
    ceres::Solve(sparse_solver(options_.iterations), &problem, &summary);
    return summary;
  }

  void set_weights() {
    for (Constraint* edge : edges_) {
      double kernel[3] = {0.0, 1.0, 0.0};
      if (const auto loss = loss_for(*edge, options_.switch_price)) loss->Evaluate(error_of(*edge), kernel);
      edge->weight = kernel[1];
    }
  }

  std::vector<Pose>& poses_;
  std::span<const std::uint8_t> fixed_;
  const PoseGraphOptions& options_;
  std::vector<Constraint*> edges_;   ///< All edges that are used.
  std::vector<std::uint8_t> moves_;  ///< For each pose: whether it is free and has an edge.
  std::vector<typename Space::Values> values_;
};

}  // namespace

template <GraphPose Pose>
PoseGraphResult optimize_pose_graph(std::vector<Pose>& world_from_pose, std::span<Constraint> edges,
                                    std::span<const std::uint8_t> fixed, const PoseGraphOptions& options) {
  RASTRO_CHECK(fixed.size() == world_from_pose.size(), "every pose is fixed or free");
  return Graph<Pose>(world_from_pose, edges, fixed, options).run();
}

template <GraphPose Pose>
typename Pose::Tangent edge_residual(const Constraint& edge, const Pose& world_from_from, const Pose& world_from_to) {
  using Space = PoseSpace<Pose>;
  return Space::residual(Space::relative(edge).inverse() * world_from_from.inverse() * world_from_to);
}

template <GraphPose Pose>
double squared_sigmas(const Constraint& edge, const Pose& world_from_from, const Pose& world_from_to,
                      const PoseGraphOptions& options) {
  const typename Pose::Tangent residual = edge_residual(edge, world_from_from, world_from_to);
  return residual.dot(PoseSpace<Pose>::information(edge, options) * residual);
}

template PoseGraphResult optimize_pose_graph(std::vector<SE2>&, std::span<Constraint>, std::span<const std::uint8_t>,
                                             const PoseGraphOptions&);
template PoseGraphResult optimize_pose_graph(std::vector<SE3>&, std::span<Constraint>, std::span<const std::uint8_t>,
                                             const PoseGraphOptions&);
template PoseGraphResult optimize_pose_graph(std::vector<Sim3>&, std::span<Constraint>, std::span<const std::uint8_t>,
                                             const PoseGraphOptions&);
template SE2::Tangent edge_residual(const Constraint&, const SE2&, const SE2&);
template SE3::Tangent edge_residual(const Constraint&, const SE3&, const SE3&);
template Sim3::Tangent edge_residual(const Constraint&, const Sim3&, const Sim3&);
template double squared_sigmas(const Constraint&, const SE2&, const SE2&, const PoseGraphOptions&);
template double squared_sigmas(const Constraint&, const SE3&, const SE3&, const PoseGraphOptions&);
template double squared_sigmas(const Constraint&, const Sim3&, const Sim3&, const PoseGraphOptions&);

}  // namespace rastro
