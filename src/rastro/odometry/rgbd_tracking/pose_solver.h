// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <utility>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// A point of the map and its observation in the frame.
struct PointMeasurement {
  Eigen::Vector3d in_world;
  Eigen::Vector3d in_world_per_inverse_depth;  ///< Derivative of the point by its inverse depth, m^2.
  double inverse_depth_variance = 0.0;         ///< Of the map's inverse depth, 1/m^2.
  Eigen::Vector2d ray;                         ///< Normalized.
  double ray_sigma = 0.002;
  double inverse_depth = 0.0;  ///< Measured in this frame; 0: none.
  double inverse_depth_sigma = 1.0;
  /// Derivatives of the reading and of the map's inverse depth by the delay of depth, 1/m/s.
  double per_second = 0.0, map_per_second = 0.0;
};

/// Quadratic approximation 0.5 d^T H d - b^T d of a cost around a pose; d acts as pose * exp(d).
struct PoseQuadratic {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();  ///< b: the negative gradient.

  PoseQuadratic& operator+=(const PoseQuadratic& other) {
    information += other.information;
    gradient += other.gradient;
    return *this;
  }
};

/// Cost of the points, with a Cauchy kernel of `kernel` standard deviations.
PoseQuadratic points_quadratic(const std::vector<PointMeasurement>& points, const SE3& world_from_camera,
                               double kernel);

/// As PoseQuadratic, with one more unknown, the last: the correction of the delay of depth (seconds).
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

/// Evidence on the delay with the pose marginalized: information (1/s^2) and gradient (1/s).
std::pair<double, double> delay_alone(const DelayedQuadratic& quadratic);

struct PoseSolution {
  SE3 world_from_camera;
  PoseQuadratic points;         ///< At the solution, with independent points.
  PoseQuadratic shared_points;  ///< With the error common to all points.
  PoseQuadratic others;
  Vector6d shared_variance = Vector6d::Zero();  ///< Of the error common to all points.
  bool converged = false;

  /// Solution from the points alone.
  SE3 by_points_alone() const;
  /// Inverse covariance of the motion since a frame that has the same common error, but for this share of it.
  Matrix6d information_of_motion(double unshared) const;
};

/// Gauss-Newton over the points and `others` (may be empty) together. `shared_ray_error` is an error common to all
/// points (normalized; color and depth are never registered perfectly): it bounds the certainty of many points.
/// Unobservable directions keep their value.
PoseSolution solve_pose(const std::vector<PointMeasurement>& points, double shared_ray_error, const SE3& start,
                        int iterations, const std::function<PoseQuadratic(const SE3&, int iteration)>& others = {});

}  // namespace rastro
