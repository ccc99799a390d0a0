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

/// A point as one camera sees it, in the normalised plane (x/z, y/z) of that camera.
struct BundleObservation {
  std::uint32_t camera = 0, point = 0;            ///< Indices into the bundle.
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();  ///< Undistorted.
  /// x in the right camera, (x - baseline) / z: seen there, or what a depth says of it. Not a number: unknown.
  double right_x = std::numeric_limits<double>::quiet_NaN();
  double sigma =
      1.0 / 500.0;  ///< Standard deviation of each number above: of the feature's level, by the focal length.
};

/// Cameras, points, and what they see of each other.
struct Bundle {
  std::vector<SE3> camera_from_world;
  std::vector<std::uint8_t> fixed;  ///< One a camera; not zero: it stays where it is.
  std::vector<Eigen::Vector3d> points;
  std::vector<BundleObservation> observations;  ///< In any order; the order of summation follows it.
  double baseline = 0.0;                        ///< Between left and right camera, in the unit of the points.
};

struct BundleOptions {
  int iterations = 10;  ///< At most.
  double huber_mono =
      2.4477;  ///< Sigmas from which errors count linearly: 95 % of chi squared, 2 degrees of freedom...
  double huber_stereo = 2.7955;   ///< ... and 3, where right_x is known. 0, both: plain least squares.
  double least_gain = 1e-5;       ///< Share of the cost by which an iteration must lower it, else it was the last.
  std::function<bool()> stopped;  ///< Once true no iteration is begun any more; those done stand. May be empty.
};

struct BundleResult {
  int iterations = 0;  ///< Steps tried.
  bool converged = false;
  double first_cost = 0.0, last_cost = 0.0;  ///< Half the sum of squared sigmas, kernel included.
  /// One an observation, in sigmas, without the kernel; infinite behind the camera. Where each is above the chi
  /// squared bound (5.991, with right_x 7.815) it is an outlier.
  std::vector<double> squared_errors;
};

/// Bundle adjustment: Levenberg-Marquardt with the points eliminated by the Schur complement (Triggs et al. 2000,
/// "Bundle adjustment: a modern synthesis", sections 4 and 6) and Huber's kernel. Moves the free cameras and the
/// points; what the observations do not hold stays about where it is. With neither a fixed camera nor a known right_x
/// the result is fixed up to a similarity only. The same bytes for any pool.
BundleResult adjust_bundle(Bundle& bundle, const BundleOptions& options, TaskPool* pool = nullptr);

}  // namespace rastro
