// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/math/se3.h"

namespace rastro {

/// A camera's observation of a point, in the normalized plane (x/z, y/z) of that camera.
struct BundleObservation {
  std::uint32_t camera = 0, point = 0;            ///< Indices into the bundle.
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();  ///< Undistorted.
  /// x in the right camera, (x - baseline) / z, observed or from a depth. NaN: unknown.
  double right_x = std::numeric_limits<double>::quiet_NaN();
  /// Standard deviation of each number above: that of the feature's level, divided by the focal length.
  double sigma = 1.0 / 500.0;
};

/// Pose of one camera relative to another, measured by other means than the points.
struct BundleRelativePose {
  std::uint32_t from = 0, to = 0;  ///< Cameras of the bundle.
  SE3 to_from_from;
  Matrix6d information = Matrix6d::Identity();  ///< Of d in true pose = exp(d) * to_from_from.
};

/// Cameras, points and observations.
struct Bundle {
  std::vector<SE3> camera_from_world;
  std::vector<std::uint8_t> fixed;  ///< One per camera; nonzero: it stays fixed.
  std::vector<Eigen::Vector3d> points;
  std::vector<BundleObservation> observations;  ///< In any order; the order of summation follows it.
  std::vector<BundleRelativePose> relative_poses = {};
  double baseline = 0.0;  ///< Between left and right camera, in the unit of the points.
};

struct BundleOptions {
  int iterations = 10;  ///< Maximum.
  /// Sigmas beyond which residuals count linearly: 95 % of chi squared with 2 degrees of freedom, and with 3 where
  /// right_x is known. 0 for both: plain least squares.
  double huber_mono = 2.4477;
  double huber_stereo = 2.7955;
  double huber_pose = 3.5485;     ///< Of a relative pose, with 6 degrees of freedom.
  double least_gain = 1e-5;       ///< Relative decrease of the cost below which an iteration is the last.
  std::function<bool()> stopped;  ///< Once true, no further iteration starts; the result so far stays. May be empty.
};

struct BundleResult {
  int iterations = 0;  ///< Steps tried.
  bool converged = false;
  double first_cost = 0.0, last_cost = 0.0;  ///< Half the sum of squared residuals in sigmas, after the kernel.
  /// One per observation, in squared sigmas, without the kernel; infinite behind the camera. An observation above the
  /// chi-squared bound (5.991, with right_x 7.815) is an outlier.
  std::vector<double> squared_errors;
};

/// Bundle adjustment: Levenberg-Marquardt with the points eliminated by the Schur complement (Triggs et al. 2000,
/// "Bundle adjustment: a modern synthesis", sections 4 and 6) and Huber's kernel. Moves the free cameras and the
/// points; unconstrained ones stay about where they are. With neither a fixed camera nor a known right_x the result is
/// determined only up to a similarity. The same bytes for any pool.
BundleResult adjust_bundle(Bundle& bundle, const BundleOptions& options, TaskPool* pool = nullptr);

}  // namespace rastro
