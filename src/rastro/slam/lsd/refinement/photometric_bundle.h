// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

/// A pixel with its inverse depth along the optical axis of its keyframe, in the world's unit.
struct PhotometricPoint {
  int x = 0, y = 0;
  double inverse_depth = 1.0;
  double measured = 0.0;        ///< What a sensor says of it.
  double measured_sigma = 0.0;  ///< Its standard deviation; 0: there is no such sensor.
  /// Found: standard deviation of the inverse depth, as if the poses were exact and no pixels erred alike. 0: unknown,
  /// as no other keyframe shows the point.
  double sigma = 0.0;
};

/// A keyframe of the bundle: an undistorted image, its pose, its points, and the keyframes that they are compared with.
struct PhotometricKeyframe {
  GrayView image;
  SE3 camera_from_world;
  bool fixed = false;
  std::vector<PhotometricPoint> points;
  std::vector<std::int32_t> targets;  ///< Indices.
  GrayView mask = {};                 ///< What is zero in it is not compared; empty: all is.
};

struct PhotometricBundleOptions {
  int iterations = 10;  ///< At most.
  double huber = 9.0;   ///< Intensity levels, beyond which residuals count linearly (Huber 1964).
  /// Levels per pixel: pixels with larger gradients count less, as errors of depth and interpolation show there (ibid.,
  /// equation 7).
  double gradient_scale = 20.0;
  double intensity_sigma = 5.0;               ///< Of a residual, against which a measured depth counts.
  double outlier = 40.0;                      ///< Residuals count no more than this: the point is hidden there.
  double least_gain = 1e-6;                   ///< Relative decrease of the cost below which an iteration is the last.
  std::function<void(int iteration)> begins;  ///< Called before each iteration. May be empty.
  std::function<bool()> stopped;  ///< Once true, the step at hand is dropped; the result so far stays. May be empty.
};

struct PhotometricBundleResult {
  int iterations = 0;  ///< Steps tried.
  double first_cost = 0.0, last_cost = 0.0;
  std::int64_t residuals = 0;  ///< Of the last step: pixels compared.
};

/// Moves poses and inverse depths so that each point and the pixels around it have the same intensity in the keyframes
/// that see it, up to gain and offset for each pair: J. Engel, V. Koltun and D. Cremers, "Direct Sparse Odometry",
/// 2018, section 2, over whole images instead of a window. Gauss-Newton with Levenberg's damping, depths eliminated by
/// the Schur complement. `camera`: a pinhole without distortion. Without a fixed keyframe the result is determined up
/// to a similarity; the scale always is. The same bytes for any pool.
PhotometricBundleResult adjust_photometric_bundle(std::vector<PhotometricKeyframe>& keyframes, const Camera& camera,
                                                  const PhotometricBundleOptions& options, TaskPool* pool = nullptr);

}  // namespace rastro
