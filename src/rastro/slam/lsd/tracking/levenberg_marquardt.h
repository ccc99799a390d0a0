// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace rastro {

/// Quadratic model of a cost around a state: cost + gradient . step + 0.5 step^T hessian step, the gradient and hessian
/// of half the squared residuals.
template <int N>
struct Linearization {
  Eigen::Matrix<double, N, N> hessian = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> gradient = Eigen::Matrix<double, N, 1>::Zero();
  /// Mean over the residuals, so that states in which fewer points are visible are comparable; infinite where nothing
  /// is.
  double cost = std::numeric_limits<double>::infinity();
};

struct LevenbergMarquardtOptions {
  int iterations = 20;
  double epsilon_px = 0.01;  ///< Converged when a step moves the pixels less.
};

/// Minimizes from `state` on (Levenberg 1944, Marquardt 1963). The problem has the types State and Linear (a
/// Linearization<N>) and linearize(state), retract(state, step) and step_px(step). True if it converged; `state` and
/// `linear` are the best ones found.
template <typename Problem>
bool minimize(Problem& problem, const LevenbergMarquardtOptions& options, typename Problem::State& state,
              typename Problem::Linear& linear) {
  double damping = 1e-4;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    if (!std::isfinite(linear.cost)) return false;
    auto damped = linear.hessian;
    damped.diagonal() *= 1.0 + damping;
    const auto step = (-damped.ldlt().solve(linear.gradient)).eval();
    if (!step.allFinite()) return false;
    const auto next = problem.retract(state, step);
    const auto next_linear = problem.linearize(next);
    const bool small = problem.step_px(step) < options.epsilon_px;
    if (next_linear.cost < linear.cost) {
      state = next, linear = next_linear;
      damping = std::max(1e-6, damping * 0.1);
    } else {
      damping = std::max(1e-2, damping * 10.0);
    }
    if (small) return true;
  }
  return false;
}

/// Whether the hessian determines every direction, whatever the units of its rows are.
template <int N>
bool is_determined(const Eigen::Matrix<double, N, N>& hessian) {
  constexpr double least_share = 1e-9;
  if (!(hessian.diagonal().minCoeff() > 0.0) || !hessian.allFinite()) return false;
  const Eigen::Matrix<double, N, 1> scale = hessian.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix<double, N, N> scaled = scale.asDiagonal() * hessian * scale.asDiagonal();
  return scaled.ldlt().vectorD().minCoeff() > least_share;
}

/// Covariance of estimates from residuals of which neighbors are correlated and whose assumed variance may be wrong is
/// a multiple of the inverse hessian. The factor is measured: `scores` holds the gradient of each cluster of neighbors
/// as a column; at the minimum they add up to zero and scatter as the true noise makes them (the sandwich of Liang and
/// Zeger 1986, as one number: the mean over the directions, since few clusters cannot tell the directions apart).
template <int N>
double correlation_factor(const Eigen::Matrix<double, N, N>& hessian,
                          const Eigen::Matrix<double, N, Eigen::Dynamic>& scores) {
  // Rounding to whole intensities remains where synthetic images have no noise.
  constexpr double least = 0.01;
  const auto clusters = static_cast<double>(scores.cols());
  if (clusters < 2.0) return 1.0;
  const Eigen::Matrix<double, N, 1> mean = scores.rowwise().mean();
  const Eigen::Matrix<double, N, Eigen::Dynamic> centered = scores.colwise() - mean;
  const double trace = hessian.ldlt().solve(centered * centered.transpose()).trace();
  return std::max(least, trace / N * clusters / (clusters - 1.0));
}

}  // namespace rastro
