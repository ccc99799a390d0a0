// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// Observation of a point in one camera of a window: undistorted, normalized (x/z, y/z).
struct WindowObservation {
  int camera = 0;
  int point = 0;
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();
};

/// Cameras, points and observations. The observations of one point are contiguous.
struct RefinementWindow {
  std::vector<SE3> camera_from_world;
  std::vector<char> fixed;  ///< Cameras held fixed; at least two, or the scale is free.
  std::vector<Eigen::Vector3d> points;
  std::vector<WindowObservation> observations;
  double focal_px = 500.0;  ///< Converts rays to pixels.
};

struct RefinementOptions {
  int iterations = 6;
  double huber_px = 1.0;  ///< Larger errors count linearly (Huber 1964).
};

/// Bundle adjustment of a small window: Levenberg-Marquardt with the points eliminated by the Schur complement (Triggs
/// et al. 2000, sections 4 and 6). Changes the free cameras and all points. Returns the RMS reprojection error in
/// pixels. The same input gives the same bytes.
double refine_window(RefinementWindow& window, const RefinementOptions& options);

/// Reprojection error of a point in pixels; 1e9 behind the camera.
double reprojection_error_px(const SE3& camera_from_world, const Eigen::Vector3d& point, const Eigen::Vector2d& ray,
                             double focal_px);

}  // namespace rastro
