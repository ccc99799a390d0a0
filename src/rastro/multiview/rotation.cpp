// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/rotation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/math/median.h"
#include "rastro/multiview/ransac.h"

namespace rastro {
namespace {

/// Axes spanned by two directions, independent of their rotation; nullopt for two equal ones.
std::optional<Eigen::Matrix3d> axes_of(const Eigen::Vector2d& first, const Eigen::Vector2d& second) {
  const Eigen::Vector3d p = first.homogeneous().normalized(), q = second.homogeneous().normalized();
  const Eigen::Vector3d sum = p + q, difference = p - q;
  if (!(difference.squaredNorm() > 1e-8)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(0) = sum.normalized();
  axes.col(1) = difference.normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

class RotationProblem {
 public:
  static constexpr std::size_t sample_size = 2;
  RotationProblem(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b, double focal_px)
      : a_(a), b_(b), focal_px_(focal_px) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      pixels_.add((focal_px * a[i]).cast<float>(), (focal_px * b[i]).cast<float>());
    }
  }

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 2>& sample, Sink&& sink) const {
    const auto from = axes_of(a_[sample[0]], a_[sample[1]]), to = axes_of(b_[sample[0]], b_[sample[1]]);
    if (from && to) sink(Eigen::Matrix3d(*to * from->transpose()));
  }

  void errors(const Eigen::Matrix3d& rotation, float* out) const {
    const auto focal = static_cast<float>(focal_px_);
    const Eigen::Matrix3f m = rotation.cast<float>();
    const float r00 = m(0, 0), r01 = m(0, 1), r02 = m(0, 2) * focal, r10 = m(1, 0), r11 = m(1, 1);
    const float r12 = m(1, 2) * focal, r20 = m(2, 0) / focal, r21 = m(2, 1) / focal, r22 = m(2, 2);
    const float *ax = pixels_.ax.data(), *ay = pixels_.ay.data(), *bx = pixels_.bx.data(), *by = pixels_.by.data();
    for (std::size_t i = 0, count = pixels_.size(); i < count; ++i) {
      const float z = r20 * ax[i] + r21 * ay[i] + r22;
      const float inverse = z > 1e-6F ? 1.0F / z : 1e6F;
      const float dx = (r00 * ax[i] + r01 * ay[i] + r02) * inverse - bx[i];
      const float dy = (r10 * ax[i] + r11 * ay[i] + r12) * inverse - by[i];
      out[i] = dx * dx + dy * dy;
    }
  }

  std::optional<Eigen::Matrix3d> refit(const RobustFit& best, float limit) const {
    Eigen::Matrix3d rotation = best.model;
    for (int i = 0; i < 2; ++i) {
      const auto next = step_from(rotation, best.squared_errors, limit);
      if (!next) return std::nullopt;
      rotation = *next;
    }
    return rotation;
  }

  /// One Gauss-Newton step on the errors in image b.
  std::optional<Eigen::Matrix3d> step_from(const Eigen::Matrix3d& rotation, const std::vector<float>& squared_errors,
                                           float limit) const {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < a_.size(); ++i) {
      if (!(squared_errors[i] <= limit)) continue;
      const Eigen::Vector3d p = rotation * a_[i].homogeneous();
      const Eigen::Vector2d projected = p.hnormalized(), rest = b_[i] - projected;
      const double x = projected.x(), y = projected.y();
      Eigen::Matrix<double, 2, 3> jacobian;  // by a rotation from the left
      jacobian << -x * y, 1.0 + x * x, -y, -1.0 - y * y, x * y, x;
      normal.noalias() += jacobian.transpose() * jacobian;
      right.noalias() += jacobian.transpose() * rest;
    }
    const Eigen::Vector3d step = normal.ldlt().solve(right);
    if (!step.allFinite() || step.norm() > 1.0) return std::nullopt;
    return Eigen::Matrix3d((SO3::exp(step) * SO3::from_matrix(rotation)).matrix());
  }

 private:
  std::span<const Eigen::Vector2d> a_, b_;
  double focal_px_;
  PointPairs pixels_;
};

double median_of_roots(std::vector<float> squares) {
  for (float& value : squares) {
    if (!std::isfinite(value)) value = std::numeric_limits<float>::max();
  }
  return std::sqrt(static_cast<double>(upper_median(std::move(squares))));
}

}  // namespace

std::optional<RotationFit> rotation_between(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b,
                                            const CalibratedRansacOptions& options) {
  RASTRO_CHECK(a.size() == b.size(), "pairs have two points");
  const RotationProblem problem(a, b, options.focal_px);
  auto found = ransac_of<Eigen::Matrix3d>(problem, a.size(), options);
  if (!found) return std::nullopt;
  const auto limit = static_cast<float>(options.max_error_px * options.max_error_px);
  if (const auto refined = problem.refit(*found, limit)) {
    found->model = *refined;
    problem.errors(found->model, found->squared_errors.data());
  }
  RotationFit fit;
  fit.second_from_first = SO3::from_matrix(found->model);
  fit.iterations = found->iterations;
  for (const float error : found->squared_errors) fit.is_inlier.push_back(error <= limit ? 1 : 0);
  fit.inliers = static_cast<int>(std::count(fit.is_inlier.begin(), fit.is_inlier.end(), 1));
  fit.median_error_px = median_of_roots(found->squared_errors);
  return fit;
}

}  // namespace rastro
