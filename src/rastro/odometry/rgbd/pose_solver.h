// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
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

/// What a frame says of how much later depth was taken than its stamps say, the pose eliminated.
struct DelayQuadratic {
  double information = 0.0;  ///< 1/s^2
  double gradient = 0.0;     ///< Downhill.
};
DelayQuadratic delay_quadratic(const std::vector<PointMeasurement>& points, const SE3& world_from_camera);

struct PoseSolution {
  SE3 world_from_camera;
  PoseQuadratic points;  ///< At the solution.
  PoseQuadratic others;
  bool converged = false;
};

/// Gauss-Newton over the points and `others` (may be empty) together. Directions that nothing measures stay as they
/// are.
PoseSolution solve_pose(const std::vector<PointMeasurement>& points, const SE3& start, int iterations,
                        const std::function<PoseQuadratic(const SE3&, int iteration)>& others = {});

}  // namespace rastro
