// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/synthetic/path.h"

namespace rastro::loop {

constexpr double rate_hz = 20.0, speed = 1.6, camera_height_m = 1.6;

/// A point of the path with its direction.
struct PathPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< Meters.
  double heading = 0.0;                                ///< Radians from the x axis to the left, without jumps.
};

/// Length of the whole path, and of the part that leads back to the start.
double path_m();
double round_m();
/// At a path length (meters) from the start; clamped to the ends.
PathPoint path_point(double distance);

/// Trajectory of the hand-held camera on this walk, with the cut to another place.
CameraPath walk_path();

}  // namespace rastro::loop
