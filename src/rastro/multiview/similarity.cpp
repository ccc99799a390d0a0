// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/similarity.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "rastro/math/alignment.h"
#include "rastro/math/robust_kernel.h"
#include "rastro/multiview/ransac.h"

namespace rastro {
namespace {

/// Scaled rotation and translation.
using SimilarityMatrix = Eigen::Matrix<double, 3, 4>;

constexpr double least_depth = 1e-9;
/// Squared standardised error of a point behind a camera.
constexpr double behind = 1e8;

SimilarityMatrix matrix_of(const Sim3& similarity) { return similarity.matrix().topRows<3>(); }

Sim3 similarity_of(const SimilarityMatrix& matrix) {
  const double scale = std::cbrt(matrix.leftCols<3>().col(0).cross(matrix.col(1)).dot(matrix.col(2)));
  return Sim3(scale, SO3::from_matrix(matrix.leftCols<3>() / scale), matrix.col(3));
}

double squared_error(const Eigen::Vector3d& p, const Eigen::Vector2d& ray, double sigma) {
  return p.z() > least_depth ? (p.hnormalized() - ray).squaredNorm() / (sigma * sigma) : behind;
}

/// Squared standardised errors in the first and second camera.
struct BothErrors {
  double first, second;
};

BothErrors errors_of(const SimilarityPair& pair, const Sim3& first_from_second, const Sim3& second_from_first) {
  return {squared_error(first_from_second * pair.second_point, pair.first_ray, pair.first_sigma),
          squared_error(second_from_first * pair.first_point, pair.second_ray, pair.second_sigma)};
}

struct Normal {
  Matrix7d matrix = Matrix7d::Zero();
  Vector7d right = Vector7d::Zero();
  double cost = 0.0;

  /// `by_step`: derivative of the point p by the step of the similarity.
  void add(const Eigen::Vector3d& p, const Eigen::Matrix<double, 3, 7>& by_step, const Eigen::Vector2d& ray,
           double sigma, const HuberKernel& kernel) {
    if (!(p.z() > least_depth)) {
      cost += kernel.cost(behind);
      return;
    }
    const double unit = 1.0 / sigma, inverse = 1.0 / p.z(), x = p.x() * inverse, y = p.y() * inverse;
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << inverse, 0.0, -x * inverse, 0.0, inverse, -y * inverse;
    const Eigen::Matrix<double, 2, 7> jacobian = unit * by_point * by_step;
    const Eigen::Vector2d rest = unit * (ray - Eigen::Vector2d(x, y));
    const double squared = rest.squaredNorm(), weight = kernel.weight(squared);
    matrix.noalias() += weight * jacobian.transpose() * jacobian;
    right.noalias() += weight * jacobian.transpose() * rest;
    cost += kernel.cost(squared);
  }

  /// Derivative for the point p, whose depth in the camera itself is `depth`.
  void add_depth(const Eigen::Vector3d& p, const Eigen::Matrix<double, 3, 7>& by_step, double depth, double sigma,
                 const HuberKernel& kernel) {
    if (!(p.z() > least_depth && depth > least_depth)) return;
    const Eigen::Matrix<double, 1, 7> jacobian = by_step.row(2) / (sigma * p.z());
    const double rest = std::log(depth / p.z()) / sigma, weight = kernel.weight(rest * rest);
    matrix.noalias() += weight * jacobian.transpose() * jacobian;
    right.noalias() += weight * jacobian.transpose() * rest;
    cost += kernel.cost(rest * rest);
  }
};

/// Velocity of a point under a step of the similarity from the left.
Eigen::Matrix<double, 3, 7> moves(const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 3, 7> result;
  result << Eigen::Matrix3d::Identity(), -hat(p), p;
  return result;
}

template <typename Use>
Normal normal_at(const Sim3& first_from_second, std::span<const SimilarityPair> pairs, const SimilarityOptions& options,
                 const Use& use) {
  const HuberKernel kernel{std::sqrt(options.chi2)};
  const Sim3 second_from_first = first_from_second.inverse();
  const Eigen::Matrix3d linear = second_from_first.matrix().topLeftCorner<3, 3>();
  Normal normal;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!use(i)) continue;
    const SimilarityPair& pair = pairs[i];
    const Eigen::Vector3d in_first = first_from_second * pair.second_point;
    normal.add(in_first, moves(in_first), pair.first_ray, pair.first_sigma, kernel);
    if (!options.fix_scale)
      normal.add_depth(in_first, moves(in_first), pair.first_point.z(), options.depth_sigma, kernel);
    normal.add(second_from_first * pair.first_point, -linear * moves(pair.first_point), pair.second_ray,
               pair.second_sigma, kernel);
  }
  if (options.fix_scale) {
    normal.matrix.row(6).setZero();
    normal.matrix.col(6).setZero();
    normal.matrix(6, 6) = 1.0;
    normal.right[6] = 0.0;
  }
  return normal;
}

/// Gauss-Newton, damped only where a step would increase the cost; nullopt if the pairs do not determine it.
template <typename Use>
std::optional<Sim3> refine(const Sim3& start, std::span<const SimilarityPair> pairs, const SimilarityOptions& options,
                           int iterations, const Use& use) {
  Sim3 best = start;
  Normal normal = normal_at(best, pairs, options, use);
  double damping = 0.0;
  for (int i = 0; i < iterations; ++i) {
    Matrix7d matrix = normal.matrix;
    matrix.diagonal() *= 1.0 + damping;
    const Eigen::LDLT<Matrix7d> solver(matrix);
    const double largest = solver.vectorD().cwiseAbs().maxCoeff();
    if (!(solver.vectorD().minCoeff() > 1e-13 * largest)) return std::nullopt;
    const Vector7d step = solver.solve(normal.right);
    if (!step.allFinite()) return std::nullopt;
    const Sim3 next = Sim3::exp(step) * best;
    const Normal there = normal_at(next, pairs, options, use);
    if (!(there.cost <= normal.cost)) {
      damping = std::max(1e-4, 10.0 * damping);
      continue;
    }
    const double gain = normal.cost - there.cost;
    best = next;
    normal = there;
    damping *= 0.1;
    if (gain <= 1e-9 * normal.cost) break;
  }
  return best;
}

class SimilarityProblem {
 public:
  static constexpr std::size_t sample_size = 3;
  SimilarityProblem(std::span<const SimilarityPair> pairs, const SimilarityOptions& options)
      : pairs_(pairs), options_(options) {}

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 3>& sample, Sink&& sink) const {
    std::array<Eigen::Vector3d, 3> first, second;
    for (std::size_t k = 0; k < 3; ++k) {
      first[k] = pairs_[sample[k]].first_point;
      second[k] = pairs_[sample[k]].second_point;
    }
    const auto aligned =
        align_points(first, second, options_.fix_scale ? AlignmentKind::rigid : AlignmentKind::similarity);
    if (aligned && aligned->unique && aligned->target_from_source.scale() > 1e-9)
      sink(matrix_of(aligned->target_from_source));
  }

  void errors(const SimilarityMatrix& model, float* out) const {
    const Sim3 first_from_second = similarity_of(model), second_from_first = first_from_second.inverse();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const BothErrors both = errors_of(pairs_[i], first_from_second, second_from_first);
      out[i] = static_cast<float>(std::max(both.first, both.second));
    }
  }

  std::optional<SimilarityMatrix> refit(const RobustFitOf<SimilarityMatrix>& best, float limit) const {
    if (best.inliers < 4) return std::nullopt;
    const auto refined = refine(similarity_of(best.model), pairs_, options_, 3,
                                [&](std::size_t i) { return best.squared_errors[i] <= limit; });
    return refined ? std::optional(matrix_of(*refined)) : std::nullopt;
  }

 private:
  std::span<const SimilarityPair> pairs_;
  const SimilarityOptions& options_;
};

void judge(std::span<const SimilarityPair> pairs, double chi2, SimilarityFit& fit) {
  const Sim3 second_from_first = fit.first_from_second.inverse();
  fit.is_inlier.assign(pairs.size(), 0);
  fit.inliers = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const BothErrors both = errors_of(pairs[i], fit.first_from_second, second_from_first);
    fit.is_inlier[i] = both.first <= chi2 && both.second <= chi2 ? 1 : 0;
    fit.inliers += fit.is_inlier[i];
  }
}

}  // namespace

std::optional<SimilarityFit> refine_similarity(std::span<const SimilarityPair> pairs, const Sim3& first_from_second,
                                               const SimilarityOptions& options) {
  SimilarityFit fit;
  fit.first_from_second = first_from_second;
  fit.is_inlier.assign(pairs.size(), 1);
  constexpr int rounds = 2, least = 3;
  for (int round = 0; round < rounds; ++round) {
    const auto refined = refine(fit.first_from_second, pairs, options, options.refine_iterations,
                                [&](std::size_t i) { return fit.is_inlier[i] != 0; });
    if (!refined) return std::nullopt;
    fit.first_from_second = *refined;
    judge(pairs, options.chi2, fit);
    if (fit.inliers < least) return std::nullopt;
  }
  return fit;
}

std::optional<SimilarityFit> estimate_similarity(std::span<const SimilarityPair> pairs,
                                                 const SimilarityOptions& options) {
  const RansacOptions ransac{std::sqrt(options.chi2), options.confidence, options.max_iterations, options.seed};
  const auto found = ransac_of<SimilarityMatrix>(SimilarityProblem(pairs, options), pairs.size(), ransac);
  if (!found || found->inliers < 3) return std::nullopt;
  SimilarityFit start;
  start.first_from_second = similarity_of(found->model);
  judge(pairs, options.chi2, start);
  const auto refined = refine(start.first_from_second, pairs, options, options.refine_iterations,
                              [&](std::size_t i) { return start.is_inlier[i] != 0; });
  SimilarityFit fit = start;
  if (refined) {
    fit.first_from_second = *refined;
    judge(pairs, options.chi2, fit);
  }
  fit.iterations = found->iterations;
  return fit.inliers < 3 ? std::nullopt : std::optional(fit);
}

}  // namespace rastro
