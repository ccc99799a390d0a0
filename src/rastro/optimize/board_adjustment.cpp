// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/board_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/optimize/lens_projection.h"

namespace rastro {
namespace {

using Values6 = std::array<double, 6>;

Values6 values_of_transform(const SE3& transform) {
  const Eigen::Vector3d rotation = transform.rotation().log(), translation = transform.translation();
  return {rotation.x(), rotation.y(), rotation.z(), translation.x(), translation.y(), translation.z()};
}

SE3 transform_of_values(const Values6& v) { return {SO3::exp({v[0], v[1], v[2]}), {v[3], v[4], v[5]}}; }

/// Center and half size of the board, by which its bow is counted.
struct Extent {
  Eigen::Vector2d center, half;
  explicit Extent(const std::vector<Eigen::Vector2d>& board) {
    Eigen::Vector2d low = board.front(), high = board.front();
    for (const Eigen::Vector2d& point : board) {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
    center = 0.5 * (low + high);
    half = (0.5 * (high - low)).cwiseMax(1e-9);
  }
  Eigen::Vector2d unit(const Eigen::Vector2d& point) const { return (point - center).cwiseQuotient(half); }
};

template <typename T>
void shaped(const Eigen::Vector2d& flat, const Eigen::Vector2d& unit, const T* shape, T* point) {
  point[0] = T(flat.x());
  point[1] = T(flat.y()) * (T(1.0) + shape[2]);
  point[2] = shape[0] * (1.0 - unit.x() * unit.x()) + shape[1] * (1.0 - unit.y() * unit.y());
}

template <typename T>
void transformed(const T* pose, const T* point, T* result) {
  ceres::AngleAxisRotatePoint(pose, point, result);
  for (int i = 0; i < 3; ++i) result[i] += pose[3 + i];
}

template <LensModel model>
struct CornerCost {
  Eigen::Vector2d flat, unit, seen;

  /// Of the left or only camera.
  template <typename T>
  bool operator()(const T* lens, const T* left_from_board, const T* shape, T* residual) const {
    T point[3], in_left[3];
    shaped(flat, unit, shape, point);
    transformed(left_from_board, point, in_left);
    return off(lens, in_left, residual);
  }

  /// Of the right one.
  template <typename T>
  bool operator()(const T* lens, const T* right_from_left, const T* left_from_board, const T* shape,
                  T* residual) const {
    T point[3], in_left[3], in_right[3];
    shaped(flat, unit, shape, point);
    transformed(left_from_board, point, in_left);
    transformed(right_from_left, in_left, in_right);
    return off(lens, in_right, residual);
  }

  template <typename T>
  bool off(const T* lens, const T* in_camera, T* residual) const {
    T pixel[2];
    if (!project_by<model>(lens, in_camera, pixel)) return false;
    residual[0] = seen.x() - pixel[0];
    residual[1] = seen.y() - pixel[1];
    return true;
  }
};

/// Holds the denominator of the rational model where nothing else does: in narrow images it cancels against the
/// numerator, and the equations would be singular. With noise of 0.2 px its standard deviation is 20, where a lens that
/// needs the model determines its coefficients to 1 or better.
struct RationalPrior {
  template <typename T>
  bool operator()(const T* lens, T* residual) const {
    constexpr double px_a_unit = 0.01;
    for (int k = 0; k < 3; ++k) residual[k] = px_a_unit * lens[9 + k];
    return true;
  }
};

/// The problem as Ceres has it: parameters as arrays, one residual of two rows per corner.
class BoardNormal {
 public:
  BoardNormal(const BoardProblem& problem, const BoardAdjustmentOptions& options)
      : given_(problem), options_(options), extent_(problem.board) {
    for (const Lens& lens : problem.lenses) lenses_.push_back(lens.parameters);
    for (const SE3& pose : problem.left_from_board) poses_.push_back(values_of_transform(pose));
    right_from_left_ = values_of_transform(problem.right_from_left);
    shape_ = {problem.shape.bow_x_m, problem.shape.bow_y_m, problem.shape.stretch_y};
    used_.assign(poses_.size(), false);
    for (const BoardView& view : problem.views) add(view);
    for (std::size_t i = 0; i < lenses_.size(); ++i)
      if (problem.lenses[i].model == LensModel::pinhole_8 && problem_.HasParameterBlock(lenses_[i].data()))
        problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<RationalPrior, 3, 12>(new RationalPrior), nullptr,
                                  lenses_[i].data());
    hold();
  }

  BoardSolution run() {
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t i = 0; i < poses_.size(); ++i)
      if (used_[i]) solver.linear_solver_ordering->AddElementToGroup(poses_[i].data(), 0);
    for (double* block : shared_blocks()) solver.linear_solver_ordering->AddElementToGroup(block, 1);
    solver.max_num_iterations = options_.iterations;
    solver.num_threads = 1;
    // A hundredth of a standard deviation changes the cost by 1e-9 of it and more.
    solver.function_tolerance = 1e-11;
    // Enough damping for directions that the prior alone holds.
    solver.max_trust_region_radius = 1e8;
    solver.parameter_tolerance = 1e-12;
    solver.gradient_tolerance = 1e-12;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    return result(summary.IsSolutionUsable() && summary.termination_type == ceres::CONVERGENCE);
  }

  /// Normal equations at the present values, in the order of BoardParameters.
  Eigen::MatrixXd information() {
    const BoardParameters at = parameters();
    ceres::Problem::EvaluateOptions evaluate;
    evaluate.apply_loss_function = false;
    evaluate.num_threads = 1;
    for (double* block : shared_blocks())
      if (!problem_.IsParameterBlockConstant(block)) evaluate.parameter_blocks.push_back(block);
    for (std::size_t i = 0; i < poses_.size(); ++i)
      if (used_[i]) evaluate.parameter_blocks.push_back(poses_[i].data());
    ceres::CRSMatrix jacobian;
    problem_.Evaluate(evaluate, nullptr, nullptr, nullptr, &jacobian);
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(at.count, at.count);
    RASTRO_CHECK(jacobian.num_cols == at.count, "the covariance has a row per free parameter");
    for (int row = 0; row < jacobian.num_rows; ++row) {
      const int begin = jacobian.rows[static_cast<std::size_t>(row)],
                end = jacobian.rows[static_cast<std::size_t>(row) + 1];
      for (int a = begin; a < end; ++a)
        for (int b = begin; b < end; ++b)
          information(jacobian.cols[static_cast<std::size_t>(a)], jacobian.cols[static_cast<std::size_t>(b)]) +=
              jacobian.values[static_cast<std::size_t>(a)] * jacobian.values[static_cast<std::size_t>(b)];
    }
    return information;
  }

  BoardParameters parameters() {
    BoardParameters at;
    at.poses.assign(poses_.size(), -1);
    for (auto& lens : lenses_) at.lenses.push_back(take(lens.data(), at.count));
    if (lenses_.size() > 1) at.right_from_left = take(right_from_left_.data(), at.count);
    if (options_.free_bow) at.bow = std::exchange(at.count, at.count + 2);
    if (options_.free_stretch) at.stretch = std::exchange(at.count, at.count + 1);
    for (std::size_t i = 0; i < poses_.size(); ++i)
      if (used_[i]) at.poses[i] = std::exchange(at.count, at.count + 6);
    return at;
  }

 private:
  int take(double* block, int& count) {
    if (!problem_.HasParameterBlock(block) || problem_.IsParameterBlockConstant(block)) return -1;
    return std::exchange(count, count + problem_.ParameterBlockSize(block));
  }

  void add(const BoardView& view) {
    RASTRO_CHECK(view.corners.size() == view.pixels.size() && view.corners.size() >= 4,
                 "a view has four corners or more");
    const auto frame = static_cast<std::size_t>(view.frame), camera = static_cast<std::size_t>(view.camera);
    used_[frame] = true;
    with_model(given_.lenses[camera].model, [&]<LensModel model>() {
      for (std::size_t i = 0; i < view.corners.size(); ++i) {
        const Eigen::Vector2d& flat = given_.board[static_cast<std::size_t>(view.corners[i])];
        auto* corner = new CornerCost<model>{flat, extent_.unit(flat), view.pixels[i]};
        ceres::LossFunction* loss = options_.huber_px > 0.0 ? new ceres::HuberLoss(options_.huber_px) : nullptr;
        double *lens = lenses_[camera].data(), *pose = poses_[frame].data();
        if (view.camera == 0)
          problem_.AddResidualBlock(
              new ceres::AutoDiffCostFunction<CornerCost<model>, 2, lens_size(model), 6, 3>(corner), loss, lens, pose,
              shape_.data());
        else
          problem_.AddResidualBlock(
              new ceres::AutoDiffCostFunction<CornerCost<model>, 2, lens_size(model), 6, 6, 3>(corner), loss, lens,
              right_from_left_.data(), pose, shape_.data());
      }
    });
  }

  void hold() {
    const auto constant = [&](double* block) {
      if (problem_.HasParameterBlock(block)) problem_.SetParameterBlockConstant(block);
    };
    if (!options_.free_lenses) {
      for (auto& lens : lenses_) constant(lens.data());
      constant(right_from_left_.data());
    }
    if (!options_.free_bow && !options_.free_stretch) {
      constant(shape_.data());
    } else if (problem_.HasParameterBlock(shape_.data())) {
      std::vector<int> held;
      if (!options_.free_bow) held = {0, 1};
      if (!options_.free_stretch) held.push_back(2);
      if (!held.empty()) problem_.SetManifold(shape_.data(), new ceres::SubsetManifold(3, held));
    }
  }

  std::vector<double*> shared_blocks() {
    std::vector<double*> blocks;
    const auto put = [&](double* block) {
      if (problem_.HasParameterBlock(block)) blocks.push_back(block);
    };
    for (auto& lens : lenses_) put(lens.data());
    put(right_from_left_.data());
    put(shape_.data());
    return blocks;
  }

  BoardSolution result(bool converged) {
    BoardSolution solution{given_, {}, 0.0, 0, parameters(), converged};
    BoardProblem& problem = solution.problem;
    for (std::size_t i = 0; i < lenses_.size(); ++i) problem.lenses[i].parameters = lenses_[i];
    for (std::size_t i = 0; i < poses_.size(); ++i) problem.left_from_board[i] = transform_of_values(poses_[i]);
    problem.right_from_left = transform_of_values(right_from_left_);
    problem.shape = {shape_[0], shape_[1], shape_[2]};
    std::vector<double> residuals;
    ceres::Problem::EvaluateOptions evaluate;
    evaluate.apply_loss_function = false;
    problem_.Evaluate(evaluate, nullptr, &residuals, nullptr, nullptr);
    std::size_t next = 0;
    for (const BoardView& view : problem.views) {
      auto& of_view = solution.residuals.emplace_back();
      for (std::size_t i = 0; i < view.corners.size() && next + 1 < residuals.size(); ++i, next += 2) {
        of_view.emplace_back(residuals[next], residuals[next + 1]);
        solution.squared_error += of_view.back().squaredNorm();
      }
    }
    solution.measurements = static_cast<int>(next);
    return solution;
  }

  const BoardProblem& given_;
  BoardAdjustmentOptions options_;
  Extent extent_;
  std::vector<Eigen::VectorXd> lenses_;
  std::vector<Values6> poses_;
  std::vector<bool> used_;
  Values6 right_from_left_{};
  std::array<double, 3> shape_{};
  ceres::Problem problem_;
};

/// From derivatives by the parameters of a transform as Ceres has them (axis times angle) to small rotations from the
/// left.
void rotate_block(Eigen::MatrixXd& covariance, int at, const SO3& rotation) {
  if (at < 0) return;
  const Eigen::Matrix3d jacobian = SO3::left_jacobian(rotation.log());
  covariance.middleRows<3>(at) = (jacobian * covariance.middleRows<3>(at)).eval();
  covariance.middleCols<3>(at) = (covariance.middleCols<3>(at) * jacobian.transpose()).eval();
}

}  // namespace

double BoardSolution::noise_px() const { return std::sqrt(squared_error / std::max(1, degrees_of_freedom())); }

double BoardSolution::rms_px() const { return std::sqrt(2.0 * squared_error / std::max(1, measurements)); }

BoardSolution adjust_boards(const BoardProblem& problem, const BoardAdjustmentOptions& options) {
  RASTRO_CHECK(!problem.board.empty() && !problem.lenses.empty(), "a board and a lens are needed");
  return BoardNormal(problem, options).run();
}

std::optional<Eigen::MatrixXd> board_covariance(const BoardSolution& solution) {
  BoardAdjustmentOptions options;
  const BoardParameters& at = solution.parameters;
  options.free_lenses = !at.lenses.empty() && at.lenses.front() >= 0;
  options.free_bow = at.bow >= 0;
  options.free_stretch = at.stretch >= 0;
  Eigen::MatrixXd information = BoardNormal(solution.problem, options).information();
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  information = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factors(information);
  if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-15)) return std::nullopt;
  Eigen::MatrixXd covariance =
      scale.asDiagonal() * factors.solve(Eigen::MatrixXd::Identity(at.count, at.count)) * scale.asDiagonal();
  rotate_block(covariance, at.right_from_left, solution.problem.right_from_left.rotation());
  for (std::size_t i = 0; i < at.poses.size(); ++i)
    rotate_block(covariance, at.poses[i], solution.problem.left_from_board[i].rotation());
  return covariance;
}

Eigen::Vector3d board_point(const BoardProblem& problem, int corner) {
  const Eigen::Vector2d& flat = problem.board[static_cast<std::size_t>(corner)];
  const double shape[3] = {problem.shape.bow_x_m, problem.shape.bow_y_m, problem.shape.stretch_y};
  Eigen::Vector3d point;
  shaped(flat, Extent(problem.board).unit(flat), shape, point.data());
  return point;
}

}  // namespace rastro
