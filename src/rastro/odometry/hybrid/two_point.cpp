// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/hybrid/two_point.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/multiview/ransac.h"

namespace rastro {
namespace {

constexpr float far_off = std::numeric_limits<float>::max();
constexpr int refine_iterations = 5;

TranslationFit fit_of(const RobustFitOf<Eigen::Vector3d>& found, double max_error_px) {
  TranslationFit fit;
  fit.translation = found.model;
  fit.inliers = found.inliers;
  fit.iterations = found.iterations;
  const auto limit = static_cast<float>(max_error_px * max_error_px);
  for (const float error : found.squared_errors) fit.is_inlier.push_back(error <= limit ? 1 : 0);
  return fit;
}

/// Points rotated into the current camera's directions, observed at `seen`: only t' is unknown.
struct TranslationProblem {
  static constexpr std::size_t sample_size = 2;
  const Eigen::Matrix3d& rotation;
  std::span<const Eigen::Vector3d> points;
  std::span<const Eigen::Vector2d> seen;
  double focal_px;
  std::vector<Eigen::Vector3d> rotated;

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 2>& sample, Sink&& sink) const {
    const auto [i, j] = sample;
    if (const auto t = translation_from_two_points(rotation, points[i], points[j], seen[i], seen[j])) sink(*t);
  }

  void errors(const Eigen::Vector3d& translation, float* out) const {
    for (std::size_t i = 0; i < rotated.size(); ++i) {
      const Eigen::Vector3d p = rotated[i] + translation;
      out[i] =
          p.z() > 0.0 ? static_cast<float>((p.hnormalized() - seen[i]).squaredNorm() * focal_px * focal_px) : far_off;
    }
  }

  std::optional<Eigen::Vector3d> refit(const RobustFitOf<Eigen::Vector3d>& start, float limit) const {
    Eigen::Vector3d translation = start.model;
    for (int iteration = 0; iteration < refine_iterations; ++iteration) {
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < rotated.size(); ++i) {
        if (!(start.squared_errors[i] <= limit)) continue;
        const Eigen::Vector3d p = rotated[i] + translation;
        if (!(p.z() > 0.0)) continue;
        const Eigen::Vector2d projected = p.hnormalized();
        Eigen::Matrix<double, 2, 3> jacobian;
        jacobian << 1.0, 0.0, -projected.x(), 0.0, 1.0, -projected.y();
        jacobian /= p.z();
        normal.noalias() += jacobian.transpose() * jacobian;
        right.noalias() += jacobian.transpose() * (seen[i] - projected);
      }
      const Eigen::Vector3d step = normal.ldlt().solve(right);
      if (!step.allFinite()) return std::nullopt;
      translation += step;
      if (step.norm() <= 1e-9 * translation.norm()) break;
    }
    return translation;
  }
};

/// Normals b x R a of the planes that t lies in; errors are distances in pixels from the line that t and R a span.
struct DirectionProblem {
  static constexpr std::size_t sample_size = 2;
  std::vector<Eigen::Vector3d> rotated, normals;
  std::span<const Eigen::Vector2d> seen;
  double focal_px;

  template <typename Sink>
  void fit(const std::array<std::uint32_t, 2>& sample, Sink&& sink) const {
    const Eigen::Vector3d t = normals[sample[0]].cross(normals[sample[1]]);
    const double length = t.norm(), most = normals[sample[0]].norm() * normals[sample[1]].norm();
    if (length > 1e-6 * most) sink(Eigen::Vector3d(t / length));
  }

  void errors(const Eigen::Vector3d& t, float* out) const {
    for (std::size_t i = 0; i < rotated.size(); ++i) {
      const Eigen::Vector3d line = t.cross(rotated[i]);
      const double square = line.head<2>().squaredNorm(), distance = line.dot(seen[i].homogeneous().eval());
      out[i] = square > 0.0 ? static_cast<float>(distance * distance / square * focal_px * focal_px) : far_off;
    }
  }

  std::optional<Eigen::Vector3d> refit(const RobustFitOf<Eigen::Vector3d>& start, float limit) const {
    Eigen::Vector3d t = start.model;
    for (int iteration = 0; iteration < refine_iterations; ++iteration) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      for (std::size_t i = 0; i < rotated.size(); ++i) {
        const double square = t.cross(rotated[i]).head<2>().squaredNorm();
        // Divided by the length of the line, so that all are in pixels.
        if (start.squared_errors[i] <= limit && square > 0.0) sum += normals[i] * normals[i].transpose() / square;
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum);
      if (solver.info() != Eigen::Success || !(solver.eigenvalues()[1] > 0.0)) return std::nullopt;
      t = solver.eigenvectors().col(0);
    }
    return t;
  }
};

/// Points in front of both cameras with translation t, minus those in front with -t.
int balance_in_front(const DirectionProblem& problem, const TranslationFit& fit) {
  int balance = 0;
  for (std::size_t i = 0; i < problem.rotated.size(); ++i) {
    if (fit.is_inlier[i] == 0) continue;
    // s b = z R a + t: the cross products with b and with R a give the signs of the depths.
    const Eigen::Vector3d b = problem.seen[i].homogeneous();
    const Eigen::Vector3d across = problem.rotated[i].cross(b);
    const double depth_first = b.cross(fit.translation).dot(across);
    const double depth_second = problem.rotated[i].cross(fit.translation).dot(across);
    if (depth_first > 0.0 && depth_second > 0.0) ++balance;
    if (depth_first < 0.0 && depth_second < 0.0) --balance;
  }
  return balance;
}

}  // namespace

std::optional<Eigen::Vector3d> translation_from_two_points(const Eigen::Matrix3d& rotation,
                                                           const Eigen::Vector3d& point_a,
                                                           const Eigen::Vector3d& point_b, const Eigen::Vector2d& a,
                                                           const Eigen::Vector2d& b) {
  const Eigen::Vector3d across = rotation * (point_b - point_a);
  const Eigen::Vector2d difference = b - a;
  const int axis = std::abs(difference.x()) >= std::abs(difference.y()) ? 0 : 1;
  if (std::abs(difference[axis]) < 1e-9) return std::nullopt;
  const double depth_a = (across[axis] - b[axis] * across.z()) / difference[axis];
  if (!(depth_a > 0.0 && depth_a + across.z() > 0.0) || !std::isfinite(depth_a)) return std::nullopt;
  return Eigen::Vector3d(depth_a * a.homogeneous() - rotation * point_a);
}

std::optional<TranslationFit> estimate_translation(const Eigen::Matrix3d& rotation,
                                                   std::span<const Eigen::Vector3d> points_in_first,
                                                   std::span<const Eigen::Vector2d> points,
                                                   const CalibratedRansacOptions& options,
                                                   const std::optional<Eigen::Vector3d>& initial) {
  RASTRO_CHECK(points_in_first.size() == points.size(), "one pixel per point");
  TranslationProblem problem{rotation, points_in_first, points, options.focal_px, {}};
  for (const auto& point : points_in_first) problem.rotated.emplace_back(rotation * point);
  const auto found = ransac_of<Eigen::Vector3d>(problem, points.size(), options, initial);
  if (!found || found->inliers < 2 || !found->model.allFinite()) return std::nullopt;
  return fit_of(*found, options.max_error_px);
}

std::optional<TranslationFit> estimate_direction(const Eigen::Matrix3d& rotation, std::span<const Eigen::Vector2d> a,
                                                 std::span<const Eigen::Vector2d> b,
                                                 const CalibratedRansacOptions& options) {
  RASTRO_CHECK(a.size() == b.size(), "the same number of points in both views");
  DirectionProblem problem{{}, {}, b, options.focal_px};
  for (std::size_t i = 0; i < a.size(); ++i) {
    problem.rotated.emplace_back(rotation * a[i].homogeneous());
    problem.normals.emplace_back(b[i].homogeneous().cross(problem.rotated.back()));
  }
  const auto found = ransac_of<Eigen::Vector3d>(problem, a.size(), options);
  if (!found || found->inliers < 2 || !found->model.allFinite()) return std::nullopt;
  TranslationFit fit = fit_of(*found, options.max_error_px);
  const int balance = balance_in_front(problem, fit);
  if (balance == 0) return std::nullopt;
  if (balance < 0) fit.translation = -fit.translation;
  return fit;
}

}  // namespace rastro
