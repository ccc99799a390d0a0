// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/two_view_points.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "rastro/math/alignment.h"
#include "rastro/math/robust_kernel.h"
#include "rastro/multiview/absolute_pose.h"
#include "rastro/multiview/ransac.h"

namespace rastro {
namespace {

using PoseMatrix = Eigen::Matrix<double, 3, 4>;

PoseMatrix matrix_of(const SE3& pose) { return pose.matrix().topRows<3>(); }
SE3 pose_of(const PoseMatrix& matrix) { return {SO3::from_matrix(matrix.leftCols<3>()), matrix.col(3)}; }
Eigen::Vector3d point_at(const Eigen::Vector2d& ray, double depth) { return {depth * ray.x(), depth * ray.y(), depth}; }

/// Residual of a match in sigmas and its derivative by d in a_from_b * exp(d).
struct Residual {
  int rows = 0;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 6> jacobian = Eigen::Matrix<double, 3, 6>::Zero();
};

class TwoViewProblem {
 public:
  static constexpr std::size_t sample_size = 3;

  TwoViewProblem(std::span<const PointMatch> matches, const PointMatchOptions& options)
      : matches_(matches), options_(options) {
    for (std::uint32_t i = 0; i < matches.size(); ++i)
      if (matches[i].has_depth()) with_depth_.push_back(i);
  }

  template <typename Sink>
  void fit(std::array<std::uint32_t, 3> sample, Sink&& sink) const {
    // Drawn from all matches; only depths give a pose.
    if (with_depth_.size() < sample_size) return;
    for (std::uint32_t& i : sample) i = with_depth_[i * with_depth_.size() / matches_.size()];
    if (sample[0] == sample[1] || sample[1] == sample[2] || sample[0] == sample[2]) return;
    const auto all = [&](auto has) {
      return std::all_of(sample.begin(), sample.end(), [&](auto i) { return has(matches_[i]); });
    };
    const bool a = all([](const PointMatch& match) { return match.depth_a > 0.0; });
    const bool b = all([](const PointMatch& match) { return match.depth_b > 0.0; });
    if (a && b) {
      fit_points(sample, sink);
    } else if (a) {
      for (const SE3& b_from_a : fit_rays(sample, true)) sink(matrix_of(b_from_a.inverse()));
    } else if (b) {
      for (const SE3& a_from_b : fit_rays(sample, false)) sink(matrix_of(a_from_b));
    }
  }

  /// The larger of pixel and depth residual, squared sigmas.
  void errors(const PoseMatrix& model, float* out) const {
    const Eigen::Matrix3d rotation = model.leftCols<3>();
    const Eigen::Vector3d shift = model.col(3);
    for (std::size_t i = 0; i < matches_.size(); ++i) {
      const Residual residual = residual_of(matches_[i], rotation, shift, false);
      out[i] = residual.rows == 0 ? 1e30F
                                  : static_cast<float>(std::max(residual.error.head<2>().squaredNorm(),
                                                                residual.error.z() * residual.error.z()));
    }
  }

  std::optional<PoseMatrix> refit(const RobustFitOf<PoseMatrix>& best, float limit) const {
    if (best.inliers < 4) return std::nullopt;
    const auto refined = refine(pose_of(best.model), best.squared_errors, limit, 2);
    return refined ? std::optional(matrix_of(refined->pose)) : std::nullopt;
  }

  struct Refined {
    SE3 pose;
    Matrix6d normal = Matrix6d::Zero();
    double squared = 0.0;  ///< Of the residuals, weighted.
    double rows = 0.0;     ///< Weighted.
  };

  /// Gauss-Newton over the matches within `limit`.
  std::optional<Refined> refine(SE3 pose, const std::vector<float>& errors, float limit, int iterations) const {
    Refined result;
    for (int iteration = 0; iteration <= iterations; ++iteration) {
      result = {pose};
      Vector6d right = Vector6d::Zero();
      const Eigen::Matrix3d rotation = pose.rotation().matrix();
      for (std::size_t i = 0; i < matches_.size(); ++i) {
        if (!(errors[i] <= limit)) continue;
        const Residual residual = residual_of(matches_[i], rotation, pose.translation(), true);
        const double weight = HuberKernel{1.5}.weight(residual.error.squaredNorm());
        result.normal.noalias() += weight * residual.jacobian.transpose() * residual.jacobian;
        right.noalias() -= weight * residual.jacobian.transpose() * residual.error;
        result.squared += weight * residual.error.squaredNorm();
        result.rows += weight * residual.rows;
      }
      const Eigen::LDLT<Matrix6d> solver(result.normal);
      const double largest = solver.vectorD().cwiseAbs().maxCoeff();
      if (!(solver.vectorD().minCoeff() > 1e-12 * largest)) return std::nullopt;
      if (iteration == iterations) break;
      const Vector6d step = solver.solve(right);
      if (!step.allFinite()) return std::nullopt;
      pose = pose * SE3::exp(step);
    }
    return result;
  }

 private:
  template <typename Sink>
  void fit_points(const std::array<std::uint32_t, 3>& sample, Sink&& sink) const {
    std::array<Eigen::Vector3d, 3> in_a, in_b;
    for (std::size_t k = 0; k < 3; ++k) {
      in_a[k] = point_at(matches_[sample[k]].ray_a, matches_[sample[k]].depth_a);
      in_b[k] = point_at(matches_[sample[k]].ray_b, matches_[sample[k]].depth_b);
    }
    // A rigid motion preserves the distances between three points.
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const double d_a = (in_a[k] - in_a[next]).norm(), d_b = (in_b[k] - in_b[next]).norm();
      const double sigma =
          options_.noise.sigma(in_a[k].z()) + options_.noise.sigma(in_a[next].z()) + 0.01 * in_a[k].z();
      if (std::abs(d_a - d_b) > 2.0 * options_.max_sigmas * sigma) return;
    }
    const auto aligned = align_points(in_a, in_b, AlignmentKind::rigid);
    if (!aligned || !aligned->unique) return;
    sink(matrix_of(SE3(aligned->target_from_source.rotation(), aligned->target_from_source.translation())));
  }

  std::vector<SE3> fit_rays(const std::array<std::uint32_t, 3>& sample, bool points_of_a) const {
    std::array<Eigen::Vector3d, 3> points;
    std::array<Eigen::Vector2d, 3> rays;
    for (std::size_t k = 0; k < 3; ++k) {
      const PointMatch& match = matches_[sample[k]];
      points[k] = points_of_a ? point_at(match.ray_a, match.depth_a) : point_at(match.ray_b, match.depth_b);
      rays[k] = points_of_a ? match.ray_b : match.ray_a;
    }
    return pose_from_three(points, rays);
  }

  /// Without a depth: the distance of b's ray, as a sees it, from a's feature. What is nearest to the feature counts,
  /// at any depth from the nearest to infinity, so along the ray there is no constraint but at its ends.
  Residual ray_residual(const PointMatch& match, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& shift) const {
    Residual residual;
    const Eigen::Vector3d ray = match.ray_b.homogeneous(), far = rotation * ray;
    if (!(far.z() > 0.05)) return residual;
    const Eigen::Vector2d across = far.z() * shift.head<2>() - shift.z() * far.head<2>();
    const double speed = across.norm(), along = across.dot(match.ray_a - far.hnormalized());  // of the image point
    const double reach = speed * speed - along * far.z() * shift.z();
    const double nearest = 1.0 / options_.min_depth_m, wanted = along * far.z() * far.z();
    const bool inside = speed > 1e-9 && along > 0.0 && reach > 0.0 && wanted < nearest * reach;
    const double inverse_depth = inside ? wanted / reach : along > 0.0 ? nearest : 0.0;
    const Eigen::Vector3d p = far + inverse_depth * shift;
    if (!(p.z() > 0.05)) return residual;
    const double scale = options_.focal_px / std::hypot(match.sigma_a, match.sigma_b), inverse = 1.0 / p.z();
    Eigen::Matrix2d used = Eigen::Matrix2d::Identity();
    if (inside) used -= across * across.transpose() / (speed * speed);
    residual.rows = inside ? 1 : 2;
    residual.error.head<2>() = scale * used * (p.hnormalized() - match.ray_a);
    Eigen::Matrix<double, 3, 6> point_by_step;
    point_by_step << inverse_depth * rotation, -rotation * hat(ray);
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << inverse, 0.0, -p.x() * inverse * inverse, 0.0, inverse, -p.y() * inverse * inverse;
    residual.jacobian.topRows<2>() = scale * used * by_point * point_by_step;
    return residual;
  }

  /// With b's point in a if b has a depth, else with a's point in b.
  Residual residual_of(const PointMatch& match, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& shift,
                       bool with_jacobian) const {
    if (!match.has_depth()) return ray_residual(match, rotation, shift);
    const bool to_a = match.depth_b > 0.0;
    const Eigen::Vector3d in_b =
        to_a ? point_at(match.ray_b, match.depth_b)
             : Eigen::Vector3d(rotation.transpose() * (point_at(match.ray_a, match.depth_a) - shift));
    const Eigen::Vector3d p = to_a ? Eigen::Vector3d(rotation * in_b + shift) : in_b;
    Residual residual;
    if (!(p.z() > 0.05)) return residual;
    const double scale = options_.focal_px / std::hypot(match.sigma_a, match.sigma_b);
    const double inverse = 1.0 / p.z(), x = p.x() * inverse, y = p.y() * inverse;
    residual.error.head<2>() = scale * (Eigen::Vector2d(x, y) - (to_a ? match.ray_a : match.ray_b));
    residual.rows = 2;
    const bool both = to_a && match.depth_a > 0.0;
    const double depth_scale =
        both ? 1.0 / std::hypot(options_.noise.sigma(match.depth_a), options_.noise.sigma(match.depth_b)) : 0.0;
    if (both) {
      residual.error.z() = depth_scale * (p.z() - match.depth_a);
      residual.rows = 3;
    }
    if (!with_jacobian) return residual;
    Eigen::Matrix<double, 3, 6> point_by_step;  // of p
    if (to_a) {
      point_by_step << rotation, -rotation * hat(in_b);
    } else {
      point_by_step << -Eigen::Matrix3d::Identity(), hat(in_b);
    }
    Eigen::Matrix3d by_point;
    by_point << scale * inverse, 0.0, -scale * x * inverse, 0.0, scale * inverse, -scale * y * inverse, 0.0, 0.0,
        depth_scale;
    residual.jacobian.noalias() = by_point * point_by_step;
    return residual;
  }

  std::span<const PointMatch> matches_;
  PointMatchOptions options_;
  std::vector<std::uint32_t> with_depth_;
};

/// Of all, and of those with a depth.
std::pair<int, int> count_inliers(std::span<const PointMatch> matches, const std::vector<float>& errors, float limit) {
  std::pair<int, int> count;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!(errors[i] <= limit)) continue;
    ++count.first;
    count.second += matches[i].has_depth() ? 1 : 0;
  }
  return count;
}

}  // namespace

std::optional<MatchedViews> estimate_views(std::span<const PointMatch> matches, const PointMatchOptions& options,
                                           const std::optional<SE3>& guess) {
  if (matches.size() < static_cast<std::size_t>(std::max(4, options.min_inliers))) return std::nullopt;
  const TwoViewProblem problem(matches, options);
  RansacOptions ransac;
  ransac.max_error_px = options.max_sigmas;
  ransac.max_iterations = options.iterations;
  ransac.confidence = 0.999;
  ransac.seed = options.seed;
  const auto start = guess ? std::optional(matrix_of(*guess)) : std::nullopt;
  auto fit = ransac_of<PoseMatrix>(problem, matches.size(), ransac, start);
  if (!fit || fit->inliers < options.min_inliers) return std::nullopt;
  const auto limit = static_cast<float>(options.max_sigmas * options.max_sigmas);
  const auto refined = problem.refine(pose_of(fit->model), fit->squared_errors, limit, 5);
  if (!refined) return std::nullopt;
  problem.errors(matrix_of(refined->pose), fit->squared_errors.data());
  MatchedViews views;
  views.a_from_b = refined->pose;
  const auto [inliers, with_depth] = count_inliers(matches, fit->squared_errors, limit);
  if (inliers < options.min_inliers || with_depth < std::min(options.min_depth_inliers, options.min_inliers))
    return std::nullopt;
  views.inliers = inliers;
  views.information = refined->normal / std::max(1.0, refined->squared / std::max(1.0, refined->rows - 6.0));
  return views;
}

}  // namespace rastro
