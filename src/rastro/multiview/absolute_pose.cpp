// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/absolute_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/math/robust_kernel.h"
#include "rastro/multiview/ransac.h"

namespace rastro {
namespace {

/// Rotation and translation, camera_from_world.
using PoseMatrix = Eigen::Matrix<double, 3, 4>;

PoseMatrix matrix_of(const SE3& pose) { return pose.matrix().topRows<3>(); }
SE3 pose_of(const PoseMatrix& matrix) { return SE3(SO3::from_matrix(matrix.leftCols<3>()), matrix.col(3)); }

/// Closer than this share of a unit, a point counts as behind the camera: its pixel is no longer a valid measurement.
constexpr double least_depth = 1e-9;

struct Normal {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d right = Vector6d::Zero();
  double cost = 0.0;  ///< Robust, in pixels squared.
};

/// The normal equations over the points that `use` accepts, for a motion of the camera frame from the left.
template <typename Use>
Normal normal_at(const SE3& camera_from_world, std::span<const Eigen::Vector3d> world,
                 std::span<const Eigen::Vector2d> points, double focal_px, const HuberKernel& kernel, const Use& use) {
  constexpr double behind_px = 1e4;
  Normal normal;
  const Eigen::Matrix3d rotation = camera_from_world.rotation().matrix();
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (!use(i)) continue;
    const Eigen::Vector3d p = rotation * world[i] + camera_from_world.translation();
    if (!(p.z() > least_depth)) {
      normal.cost += kernel.cost(behind_px * behind_px);
      continue;
    }
    const double inverse = 1.0 / p.z(), x = p.x() * inverse, y = p.y() * inverse;
    const Eigen::Vector2d rest = focal_px * (points[i] - Eigen::Vector2d(x, y));
    Eigen::Matrix<double, 2, 6> jacobian;
    jacobian << inverse, 0.0, -x * inverse, -x * y, 1.0 + x * x, -y,  //
        0.0, inverse, -y * inverse, -1.0 - y * y, x * y, x;
    jacobian *= focal_px;
    const double weight = kernel.weight(rest.squaredNorm());
    normal.matrix.noalias() += weight * jacobian.transpose() * jacobian;
    normal.right.noalias() += weight * jacobian.transpose() * rest;
    normal.cost += kernel.cost(rest.squaredNorm());
  }
  return normal;
}

struct Refined {
  SE3 pose;
  Normal normal;
};

/// Gauss-Newton, damped only where a step would increase the cost (Levenberg 1944, Marquardt 1963).
template <typename Use>
std::optional<Refined> refine(const SE3& start, std::span<const Eigen::Vector3d> world,
                              std::span<const Eigen::Vector2d> points, const AbsolutePoseOptions& options,
                              int iterations, const Use& use) {
  const HuberKernel kernel{options.huber_px};
  const auto at = [&](const SE3& pose) { return normal_at(pose, world, points, options.focal_px, kernel, use); };
  Refined best{start, at(start)};
  double damping = 0.0;
  for (int i = 0; i < iterations; ++i) {
    Matrix6d matrix = best.normal.matrix;
    matrix.diagonal() *= 1.0 + damping;
    const Eigen::LDLT<Matrix6d> solver(matrix);
    const double largest = solver.vectorD().cwiseAbs().maxCoeff();
    if (!(solver.vectorD().minCoeff() > 1e-13 * largest)) return std::nullopt;
    const Vector6d step = solver.solve(best.normal.right);
    if (!step.allFinite()) return std::nullopt;
    const SE3 pose = SE3::exp(step) * best.pose;
    Normal normal = at(pose);
    if (!(normal.cost <= best.normal.cost * (1.0 + 1e-12) + 1e-24)) {
      damping = std::max(1e-4, 10.0 * damping);
      continue;
    }
    damping *= 0.1;
    best = {pose, normal};
    if (step.norm() < 1e-12 * (1.0 + pose.translation().norm())) break;
  }
  return best;
}

class AbsolutePoseProblem {
 public:
  static constexpr std::size_t sample_size = 3;
  /// Errors are computed in floats, so the origin is moved among the points.
  AbsolutePoseProblem(std::span<const Eigen::Vector3d> world, std::span<const Eigen::Vector2d> points,
                      const AbsolutePoseOptions& options)
      : points_(points), options_(options) {
    const auto finite = std::find_if(world.begin(), world.end(), [](const auto& p) { return p.allFinite(); });
    if (finite != world.end()) origin_ = *finite;
    for (std::size_t i = 0; i < world.size(); ++i) {
      world_.push_back(world[i] - origin_);
      for (int k = 0; k < 3; ++k) columns_[k].push_back(static_cast<float>(world_.back()(k)));
      u_.push_back(static_cast<float>(options.focal_px * points[i].x()));
      v_.push_back(static_cast<float>(options.focal_px * points[i].y()));
    }
  }

  PoseMatrix from_origin(const SE3& camera_from_world) const {
    return matrix_of(camera_from_world * SE3(SO3(), origin_));
  }
  SE3 to_world(const PoseMatrix& model) const { return pose_of(model) * SE3(SO3(), -origin_); }

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 3>& sample, Sink&& sink) const {
    const std::array<Eigen::Vector3d, 3> world{world_[sample[0]], world_[sample[1]], world_[sample[2]]};
    const std::array<Eigen::Vector2d, 3> points{points_[sample[0]], points_[sample[1]], points_[sample[2]]};
    for (const SE3& pose : pose_from_three(world, points)) sink(matrix_of(pose));
  }

  void errors(const PoseMatrix& model, float* out) const {
    Eigen::Matrix<float, 3, 4> m = model.cast<float>();
    m.topRows<2>() *= static_cast<float>(options_.focal_px);
    const float m00 = m(0, 0), m01 = m(0, 1), m02 = m(0, 2), m03 = m(0, 3), m10 = m(1, 0), m11 = m(1, 1);
    const float m12 = m(1, 2), m13 = m(1, 3), m20 = m(2, 0), m21 = m(2, 1), m22 = m(2, 2), m23 = m(2, 3);
    const float *x = columns_[0].data(), *y = columns_[1].data(), *z = columns_[2].data();
    for (std::size_t i = 0, count = u_.size(); i < count; ++i) {
      const float depth = m20 * x[i] + m21 * y[i] + m22 * z[i] + m23;
      const float inverse = 1.0F / depth;
      const float dx = (m00 * x[i] + m01 * y[i] + m02 * z[i] + m03) * inverse - u_[i];
      const float dy = (m10 * x[i] + m11 * y[i] + m12 * z[i] + m13) * inverse - v_[i];
      out[i] = depth > static_cast<float>(least_depth) ? dx * dx + dy * dy : 1e30F;
    }
  }

  std::optional<PoseMatrix> refit(const RobustFitOf<PoseMatrix>& best, float limit) const {
    if (best.inliers < 4) return std::nullopt;
    const auto refined = refine(pose_of(best.model), world_, points_, options_, 3,
                                [&](std::size_t i) { return best.squared_errors[i] <= limit; });
    return refined ? std::optional(matrix_of(refined->pose)) : std::nullopt;
  }

 private:
  std::span<const Eigen::Vector2d> points_;
  AbsolutePoseOptions options_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> world_;
  std::array<std::vector<float>, 3> columns_;
  std::vector<float> u_, v_;
};

/// Inliers, their spread, and the resulting covariance.
void judge(const Normal& normal, std::span<const Eigen::Vector3d> world, std::span<const Eigen::Vector2d> points,
           const AbsolutePoseOptions& options, AbsolutePose& result) {
  double squares = 0.0;
  result.inliers = 0;
  result.is_inlier.assign(world.size(), 0);
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Eigen::Vector3d p = result.camera_from_world * world[i];
    const double error = options.focal_px * (points[i] - p.hnormalized()).norm();
    if (!(p.z() > least_depth && error <= options.max_error_px)) continue;
    result.is_inlier[i] = 1;
    ++result.inliers;
    squares += error * error;
  }
  result.rms_px = result.inliers > 0 ? std::sqrt(squares / result.inliers) : 0.0;
  const double variance = squares / std::max(1, 2 * result.inliers - 6);
  result.covariance = variance * normal.matrix.ldlt().solve(Matrix6d::Identity());
}

}  // namespace

std::optional<AbsolutePose> refine_absolute_pose(std::span<const Eigen::Vector3d> points_in_world,
                                                 std::span<const Eigen::Vector2d> points, const SE3& start,
                                                 const AbsolutePoseOptions& options) {
  RASTRO_CHECK(points_in_world.size() == points.size(), "one pixel per point");
  if (points.size() < 3) return std::nullopt;
  const auto refined =
      refine(start, points_in_world, points, options, options.refine_iterations, [](std::size_t) { return true; });
  if (!refined) return std::nullopt;
  AbsolutePose result;
  result.camera_from_world = refined->pose;
  judge(refined->normal, points_in_world, points, options, result);
  return result;
}

std::optional<AbsolutePose> estimate_absolute_pose(std::span<const Eigen::Vector3d> points_in_world,
                                                   std::span<const Eigen::Vector2d> points,
                                                   const AbsolutePoseOptions& options,
                                                   const std::optional<SE3>& initial,
                                                   std::span<const std::int32_t> weights) {
  RASTRO_CHECK(points_in_world.size() == points.size(), "one pixel per point");
  RASTRO_CHECK(weights.empty() || weights.size() == points.size(), "one weight per point, or none");
  if (points.size() < 4) return std::nullopt;
  const AbsolutePoseProblem problem(points_in_world, points, options);
  const auto start = initial ? std::optional(problem.from_origin(*initial)) : std::nullopt;
  const auto found = ransac_of<PoseMatrix>(problem, points.size(), options, start, weights);
  if (!found || found->inliers < 4) return std::nullopt;
  const auto limit = static_cast<float>(options.max_error_px * options.max_error_px);
  const auto refined =
      refine(problem.to_world(found->model), points_in_world, points, options, options.refine_iterations,
             [&](std::size_t i) { return found->squared_errors[i] <= limit; });
  if (!refined) return std::nullopt;
  AbsolutePose result;
  result.camera_from_world = refined->pose;
  result.iterations = found->iterations;
  judge(refined->normal, points_in_world, points, options, result);
  return result.inliers < 4 ? std::nullopt : std::optional(result);
}

}  // namespace rastro
