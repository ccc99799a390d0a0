// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <utility>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// A point of the map and where the frame sees it.
struct PointMeasurement {
  Eigen::Vector3d in_world;
  Eigen::Vector3d in_world_per_inverse_depth;  ///< How the point moves when its inverse depth changes, m^2.
  double inverse_depth_variance = 0.0;         ///< Of the map's inverse depth, 1/m^2.
  Eigen::Vector2d ray;                         ///< Normalised.
  double ray_sigma = 0.002;
  double inverse_depth = 0.0;  ///< Read in this frame; 0 = not.
  double inverse_depth_sigma = 1.0;
  /// How the reading and the map's inverse depth change with the delay of depth, 1/m/s.
  double per_second = 0.0, map_per_second = 0.0;
};

/// Quadratic approximation 0.5 d^T H d - b^T d of a cost around a pose, d in pose * exp(d).
struct PoseQuadratic {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();  ///< b: downhill.

  PoseQuadratic& operator+=(const PoseQuadratic& other) {
    information += other.information;
    gradient += other.gradient;
    return *this;
  }
};

/// Of the points, with a Cauchy kernel of `kernel` standard deviations.
PoseQuadratic points_quadratic(const std::vector<PointMeasurement>& points, const SE3& world_from_camera,
                               double kernel);

/// As PoseQuadratic, with one more unknown: how much later depth was taken than thought (seconds, last).
struct DelayedQuadratic {
  Eigen::Matrix<double, 7, 7> information = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> gradient = Eigen::Matrix<double, 7, 1>::Zero();

  DelayedQuadratic& operator+=(const DelayedQuadratic& other) {
    information += other.information;
    gradient += other.gradient;
    return *this;
  }
};
DelayedQuadratic points_with_delay(const std::vector<PointMeasurement>& points, const SE3& world_from_camera);

/// What is known of the delay when the pose is not: information (1/s^2) and gradient (1/s).
std::pair<double, double> delay_alone(const DelayedQuadratic& quadratic);

struct PoseSolution {
  SE3 world_from_camera;
  PoseQuadratic points;         ///< At the solution, every point taken as independent.
  PoseQuadratic shared_points;  ///< With the error that all points share.
  PoseQuadratic others;
  bool converged = false;

  /// Where the points alone would have it.
  SE3 by_points_alone() const;
};

/// Gauss-Newton over the points and `others` (may be empty) together. `shared_ray_error` is an error that all points
/// have in common (normalised; colour and depth are never quite registered), so that many points are not surer than it.
/// Directions that nothing measures stay as they
/// are.
PoseSolution solve_pose(const std::vector<PointMeasurement>& points, double shared_ray_error, const SE3& start,
                        int iterations, const std::function<PoseQuadratic(const SE3&, int iteration)>& others = {});

}  // namespace rastro
