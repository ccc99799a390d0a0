// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/pose_solver.h"

#include <Eigen/Dense>
#include <algorithm>

#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

// Standard deviations above which an error is down-weighted.
constexpr double kernel_width = 2.0;
// Meters and radians: a smaller step is not worth another iteration.
constexpr double smallest_step = 1e-6;
// Damping of unobservable directions, far weaker than any measurement.
constexpr double hold = 1e-3;

using Matrix23 = Eigen::Matrix<double, 2, 3>;

/// Residuals of one point (right, down, inverse depth), their Jacobians and their weight.
struct Linearized {
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 6> by_pose = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Vector3d by_delay = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< The kernel's weight included.
};

bool linearize(const PointMeasurement& point, const SE3& camera_from_world, const Eigen::Matrix3d& rotation,
               const CauchyKernel& kernel, Linearized& out) {
  const Eigen::Vector3d p = camera_from_world * point.in_world;
  if (p.z() < 0.05) return false;
  const double inverse = 1.0 / p.z();
  Matrix23 projection;
  projection << inverse, 0.0, -p.x() * inverse * inverse, 0.0, inverse, -p.y() * inverse * inverse;
  const Eigen::Vector3d slide = rotation * point.in_world_per_inverse_depth;
  // With d on the right of world_from_camera: p' = exp(-d) p.
  Eigen::Matrix<double, 3, 6> motion;
  motion << -Eigen::Matrix3d::Identity(), hat(p);
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  Eigen::Matrix3d noise = Eigen::Matrix3d::Identity();
  out = {};
  out.error.head<2>() = point.ray - inverse * p.head<2>();
  out.by_pose.topRows<2>() = projection * motion;
  along.head<2>() = projection * slide;
  noise.topLeftCorner<2, 2>() *= point.ray_sigma * point.ray_sigma;
  if (point.inverse_depth > 0.0) {
    const double by_z = -inverse * inverse;
    out.error.z() = point.inverse_depth - inverse;
    out.by_pose.row(2) = by_z * motion.row(2);
    along.z() = by_z * slide.z();
    noise(2, 2) = point.inverse_depth_sigma * point.inverse_depth_sigma;
  }
  out.by_delay = along * point.map_per_second - Eigen::Vector3d::UnitZ() * point.per_second;
  // The uncertainty of the map's own depth affects all three residuals together.
  noise += point.inverse_depth_variance * along * along.transpose();
  out.information = noise.inverse();
  out.information *= kernel.weight(out.error.dot(out.information * out.error));
  return true;
}

}  // namespace

DelayedQuadratic points_with_delay(const std::vector<PointMeasurement>& points, const SE3& world_from_camera) {
  const SE3 camera_from_world = world_from_camera.inverse();
  const Eigen::Matrix3d rotation = camera_from_world.rotation().matrix();
  DelayedQuadratic sum;
  Linearized point;
  for (const PointMeasurement& measured : points) {
    if (!linearize(measured, camera_from_world, rotation, {kernel_width}, point)) continue;
    Eigen::Matrix<double, 3, 7> jacobian;
    jacobian << point.by_pose, point.by_delay;
    sum.information.noalias() += jacobian.transpose() * point.information * jacobian;
    sum.gradient.noalias() += jacobian.transpose() * point.information * point.error;
  }
  return sum;
}

std::pair<double, double> delay_alone(const DelayedQuadratic& quadratic) {
  const Matrix6d pose = quadratic.information.topLeftCorner<6, 6>() + hold * Matrix6d::Identity();
  const Vector6d cross = quadratic.information.topRightCorner<6, 1>();
  const Vector6d solved = pose.ldlt().solve(cross);
  return {std::max(0.0, quadratic.information(6, 6) - solved.dot(cross)),
          quadratic.gradient(6) - solved.dot(quadratic.gradient.head<6>())};
}

PoseQuadratic points_quadratic(const std::vector<PointMeasurement>& points, const SE3& world_from_camera,
                               double kernel) {
  PoseQuadratic sum;
  const SE3 camera_from_world = world_from_camera.inverse();
  const Eigen::Matrix3d rotation = camera_from_world.rotation().matrix();
  Linearized point;
  for (const PointMeasurement& measured : points) {
    if (!linearize(measured, camera_from_world, rotation, {kernel}, point)) continue;
    const Eigen::Matrix<double, 6, 3> weighted = point.by_pose.transpose() * point.information;
    sum.information.noalias() += weighted * point.by_pose;
    sum.gradient.noalias() += weighted * point.error;
  }
  return sum;
}

namespace {

/// Covariance of the pose due to an error common to all rays.
Vector6d shared_variance(const std::vector<PointMeasurement>& points, double ray_error, const SE3& world_from_camera) {
  double depths = 0.0;
  for (const PointMeasurement& point : points) depths += (point.in_world - world_from_camera.translation()).norm();
  const double translation_error = ray_error * depths / std::max<double>(1.0, static_cast<double>(points.size()));
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(translation_error * translation_error),
      Eigen::Vector3d::Constant(ray_error * ray_error);
  return variance;
}

/// (H^-1 + C)^-1 and its effect on the gradient, also where H cannot be inverted.
PoseQuadratic with_shared_error(const PoseQuadratic& points, const Vector6d& variance) {
  const Matrix6d scale = Matrix6d::Identity() + points.information * variance.asDiagonal();
  const Eigen::PartialPivLU<Matrix6d> inverse(scale);
  PoseQuadratic shared{inverse.solve(points.information), inverse.solve(points.gradient)};
  shared.information = 0.5 * (shared.information + shared.information.transpose()).eval();
  return shared;
}

}  // namespace

SE3 PoseSolution::by_points_alone() const {
  const Vector6d step = (points.information + hold * Matrix6d::Identity()).ldlt().solve(points.gradient);
  return step.allFinite() ? world_from_camera * SE3::exp(step) : world_from_camera;
}

Matrix6d PoseSolution::information_of_motion(double unshared) const {
  return with_shared_error(points, unshared * unshared * shared_variance).information + others.information;
}

PoseSolution solve_pose(const std::vector<PointMeasurement>& points, double shared_ray_error, const SE3& start,
                        int iterations, const std::function<PoseQuadratic(const SE3&, int iteration)>& others) {
  PoseSolution solution;
  solution.world_from_camera = start;
  solution.shared_variance = shared_variance(points, shared_ray_error, start);
  for (int i = 0; i < iterations; ++i) {
    solution.points = points_quadratic(points, solution.world_from_camera, kernel_width);
    solution.others = others ? others(solution.world_from_camera, i) : PoseQuadratic();
    solution.shared_points = with_shared_error(solution.points, solution.shared_variance);
    const Matrix6d information =
        solution.shared_points.information + solution.others.information + hold * Matrix6d::Identity();
    const Vector6d step = information.ldlt().solve(solution.shared_points.gradient + solution.others.gradient);
    if (!step.allFinite()) break;
    solution.world_from_camera = solution.world_from_camera * SE3::exp(step);
    solution.converged = step.norm() < smallest_step;
    if (solution.converged) break;
  }
  return solution;
}

}  // namespace rastro
