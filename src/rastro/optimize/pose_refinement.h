// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// A known point and its observation by the camera, normalized (x/z, y/z).
struct PoseObservation {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< In the world.
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();    ///< Undistorted.
  /// x in the right camera, (x - baseline) / z; NaN: unknown.
  double right_x = std::numeric_limits<double>::quiet_NaN();
  double sigma = 1.0 / 500.0;  ///< Standard deviation of each number above.
  /// Of the point, in the world; null: the point is certain. Uncertain points weigh less, none is an inlier for it.
  const Eigen::Matrix3d* point_covariance = nullptr;
};

struct PoseRefinementOptions {
  double baseline = 0.0;  ///< Between left and right camera, in the unit of the points.
  int rounds = 4;         ///< After each, outliers are classified again; the last two are plain least squares.
  int iterations = 10;    ///< Maximum per round.
  /// The initial value is good: outliers are classified by it, before the first round.
  bool starts_judged = false;
  double chi2_mono = 5.991;    ///< Squared sigmas beyond which an observation is an outlier...
  double chi2_stereo = 7.815;  ///< ... and where right_x is known.
};

struct PoseRefinement {
  SE3 camera_from_world;
  /// Of d in true pose = exp(d) * camera_from_world, (translation, rotation) in the camera frame, from the given sigmas
  /// and covariances and the inliers. Zero if the pose is not determined.
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<std::uint8_t> is_inlier;  ///< One per observation.
  int inliers = 0;                      ///< 0: the pose is not determined and stays at the initial value.
  double mean_squared = 0.0;            ///< Of the inliers' residuals, squared sigmas.
};

/// The pose with the smallest reprojection error: Gauss-Newton with damping where needed and Huber's kernel, in rounds
/// between which outliers are removed or readmitted. `camera_from_world` is the initial value. The same input gives the
/// same bytes.
PoseRefinement refine_pose(const SE3& camera_from_world, std::span<const PoseObservation> observations,
                           const PoseRefinementOptions& options);

}  // namespace rastro
