// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/similarity_alignment.h"

#include <algorithm>
#include <cmath>

#include "rastro/slam/lsd/tracking/similarity_residuals.h"

namespace rastro {
namespace {

using SimilarityHessian = Eigen::Matrix<double, similarity_unknowns, similarity_unknowns>;

// As that of image_alignment.cpp: what displaces the minimum in every trial.
constexpr double shared_similarity_factor = 3.0;

/// That of the first seven unknowns, whatever the brightness is.
Matrix7d information_of(const SimilarityResiduals::Linear& linear) {
  Eigen::Matrix<double, similarity_unknowns, Eigen::Dynamic> scores(similarity_unknowns,
                                                                    static_cast<int>(linear.scores.size()));
  for (std::size_t i = 0; i < linear.scores.size(); ++i) scores.col(static_cast<int>(i)) = linear.scores[i];
  const SimilarityHessian& hessian = linear.hessian;
  const Eigen::Matrix<double, 7, 2> to_brightness = hessian.topRightCorner<7, 2>();
  const Eigen::Matrix2d brightness = hessian.bottomRightCorner<2, 2>();
  const Matrix7d marginal =
      hessian.topLeftCorner<7, 7>() - to_brightness * brightness.inverse() * to_brightness.transpose();
  const double factor = shared_similarity_factor * correlation_factor<similarity_unknowns>(hessian, scores);
  return 0.5 / factor * (marginal + marginal.transpose());
}

AlignmentFailure failure_of_similarity(const SimilarityAlignment& result, const SimilarityAlignmentOptions& options,
                                       bool determined) {
  if (result.overlap < options.min_overlap) return AlignmentFailure::low_overlap;
  if (std::min(result.points, result.depth_points) < options.min_points || !determined)
    return AlignmentFailure::too_few_points;
  if (result.inlier_share < options.min_inlier_share) return AlignmentFailure::large_residual;
  return AlignmentFailure::none;
}

SimilarityAlignment similarity_of(const SimilarityState& state, const SimilarityResiduals::Linear& linear, int points,
                                  const SimilarityAlignmentOptions& options, bool converged) {
  SimilarityAlignment result;
  result.b_from_a = state.b_from_a;
  result.gain = state.brightness.gain;
  result.offset = state.brightness.absolute_offset();
  result.points = linear.used;
  result.depth_points = linear.with_depth;
  result.converged = converged;
  if (points == 0) return result;
  result.overlap = static_cast<double>(linear.inside) / points;
  result.inlier_share = static_cast<double>(linear.inliers) / std::max(1, linear.used);
  result.rms = std::sqrt(linear.squares / std::max(1, linear.used + linear.with_depth));
  const bool determined = std::isfinite(linear.cost) && is_determined<similarity_unknowns>(linear.hessian);
  if (determined) result.information = information_of(linear);
  result.failure = failure_of_similarity(result, options, determined);
  return result;
}

}  // namespace

SimilarityAlignment align_similarity(const AlignmentReference& a, const SimilarityTarget& b, const Sim3& b_from_a_guess,
                                     const SimilarityAlignmentOptions& options) {
  const int last = std::min({a.levels(), b.image.levels(), static_cast<int>(b.depth.size())}) - 1;
  const int coarsest = std::min(options.coarsest_level, last), finest = std::min(options.finest_level, coarsest);
  RASTRO_CHECK(finest >= 0, "an alignment has a level");
  SimilarityState state{b_from_a_guess, {}};
  SimilarityAlignment result;
  for (int level = coarsest; level >= finest; --level) {
    const AlignmentPoints& points = a.level(level);
    const PaddedImage& image = b.image.level(level);
    if (level == coarsest) {
      // Pixels do not depend on the unit of b.
      const SE3 rigid(b_from_a_guess.rotation(), b_from_a_guess.translation() / b_from_a_guess.scale());
      state.brightness = matched_brightness(points, image, rigid, options.noise);
    }
    SimilarityResiduals problem(points, image, b.depth[static_cast<std::size_t>(level)], options.noise,
                                options.fix_scale);
    SimilarityResiduals::Linear linear = problem.linearize(state);
    const double epsilon_px = level == finest ? options.epsilon_px : options.coarse_epsilon_px;
    const bool converged = minimize(problem, {options.iterations, epsilon_px}, state, linear);
    if (level == finest) result = similarity_of(state, linear, points.count, options, converged);
  }
  return result;
}

std::optional<double> reciprocal_error(const SimilarityAlignment& b_from_a, const SimilarityAlignment& a_from_b) {
  if (!is_determined<7>(b_from_a.information) || !is_determined<7>(a_from_b.information)) return std::nullopt;
  const Eigen::LDLT<Matrix7d> forward(b_from_a.information), backward(a_from_b.information);
  const Matrix7d identity = Matrix7d::Identity(), adjoint = a_from_b.b_from_a.inverse().adjoint();
  // With true = estimated * exp(d) on both sides, their product is exp(-adjoint d_forward) * exp(-d_backward).
  const Matrix7d covariance = adjoint * forward.solve(identity) * adjoint.transpose() + backward.solve(identity);
  const Vector7d error = (b_from_a.b_from_a * a_from_b.b_from_a).log();
  return error.dot(covariance.ldlt().solve(error));
}

}  // namespace rastro
