// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// A point as one camera of a window sees it: undistorted, normalised (x/z, y/z).
struct WindowObservation {
  int camera = 0;
  int point = 0;
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();
};

/// Cameras, points and what they see of each other. Observations of one point stand together.
struct RefinementWindow {
  std::vector<SE3> camera_from_world;
  std::vector<char> fixed;  ///< Cameras that stay where they are; at least two, or the scale is free.
  std::vector<Eigen::Vector3d> points;
  std::vector<WindowObservation> observations;
  double focal_px = 500.0;  ///< Turns rays into pixels.
};

struct RefinementOptions {
  int iterations = 6;
  double huber_px = 1.0;  ///< Errors beyond count linearly (Huber 1964).
};

/// Bundle adjustment of a small window: Levenberg-Marquardt with the points eliminated by the Schur complement (Triggs
/// et al. 2000, sections 4 and 6). Changes the free cameras and all points; returns the root mean square of the
/// reprojection errors in pixels. The same input gives the same bytes.
double refine_window(RefinementWindow& window, const RefinementOptions& options);

/// Distance in pixels between where a camera should see a point and where it does; 1e9 behind the camera.
double reprojection_error_px(const SE3& camera_from_world, const Eigen::Vector3d& point, const Eigen::Vector2d& ray,
                             double focal_px);

}  // namespace rastro
