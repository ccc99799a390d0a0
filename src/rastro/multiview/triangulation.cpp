// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/triangulation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rastro/base/error.h"

namespace rastro {
namespace {

/// The point closest to all rays in the least-squares sense.
Eigen::Vector3d midpoint(std::span<const SE3> world_from_camera, std::span<const Eigen::Vector2d> points) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d ray = (world_from_camera[i].rotation() * points[i].homogeneous().eval()).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right += across * world_from_camera[i].translation();
  }
  return normal.ldlt().solve(right);
}

/// Gauss-Newton on the sum of squared reprojection errors; each step must reduce it.
Eigen::Vector3d refined(const Eigen::Vector3d& start, std::span<const SE3> world_from_camera,
                        std::span<const Eigen::Vector2d> points) {
  Eigen::Vector3d best = start, position = start;
  double best_cost = std::numeric_limits<double>::max();
  for (int iteration = 0; iteration < 6; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double cost = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Matrix3d camera_from_world = world_from_camera[i].rotation().matrix().transpose();
      const Eigen::Vector3d p = camera_from_world * (position - world_from_camera[i].translation());
      if (!(p.z() > 0.0)) return best;
      const Eigen::Vector2d rest = points[i] - p.hnormalized();
      Eigen::Matrix<double, 2, 3> jacobian;
      jacobian << 1.0 / p.z(), 0.0, -p.x() / (p.z() * p.z()), 0.0, 1.0 / p.z(), -p.y() / (p.z() * p.z());
      jacobian = (jacobian * camera_from_world).eval();
      normal.noalias() += jacobian.transpose() * jacobian;
      right.noalias() += jacobian.transpose() * rest;
      cost += rest.squaredNorm();
    }
    if (!(cost < best_cost)) return best;
    best = position;
    best_cost = cost;
    const Eigen::Vector3d step = normal.ldlt().solve(right);
    if (!step.allFinite()) return best;
    position += step;
    if (step.norm() < 1e-12 * position.norm()) return position;
  }
  return best;
}

/// Checks the point in all views: nullopt if behind a camera.
std::optional<TriangulatedPoint> judged(const Eigen::Vector3d& position, std::span<const SE3> world_from_camera,
                                        std::span<const Eigen::Vector2d> points, double focal_px) {
  TriangulatedPoint result;
  result.position = position;
  double least_cosine = 1.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p = world_from_camera[i].inverse() * position;
    if (!(p.z() > 0.0)) return std::nullopt;
    result.error_px = std::max(result.error_px, focal_px * (points[i] - p.hnormalized()).norm());
    const Eigen::Vector3d ray = position - world_from_camera[i].translation();
    for (std::size_t k = 0; k < i; ++k) {
      const Eigen::Vector3d other = position - world_from_camera[k].translation();
      const double cosine = ray.dot(other) / (ray.norm() * other.norm());
      if (!(cosine < least_cosine)) continue;
      least_cosine = cosine;
      result.parallax_deg = std::atan2(ray.cross(other).norm(), ray.dot(other)) * 180.0 / std::numbers::pi;
    }
  }
  return result;
}

}  // namespace

std::optional<TriangulatedPoint> triangulate(std::span<const SE3> world_from_camera,
                                             std::span<const Eigen::Vector2d> points,
                                             const TriangulationOptions& options) {
  RASTRO_CHECK(world_from_camera.size() == points.size(), "every view has a camera");
  if (points.size() < 2) return std::nullopt;
  const Eigen::Vector3d start = midpoint(world_from_camera, points);
  if (!start.allFinite()) return std::nullopt;
  const auto result = judged(refined(start, world_from_camera, points), world_from_camera, points, options.focal_px);
  // Below a ten-millionth of a degree the rays are parallel and the point is rounding noise.
  if (!result || !(result->error_px <= options.max_error_px)) return std::nullopt;
  if (!(result->parallax_deg >= std::max(options.min_parallax_deg, 1e-7))) return std::nullopt;
  return result;
}

std::optional<TriangulatedPoint> triangulate(const SE3& second_from_first, const Eigen::Vector2d& a,
                                             const Eigen::Vector2d& b, const TriangulationOptions& options) {
  const std::array<SE3, 2> first_from_camera{SE3(), second_from_first.inverse()};
  const std::array<Eigen::Vector2d, 2> points{a, b};
  return triangulate(first_from_camera, points, options);
}

}  // namespace rastro
