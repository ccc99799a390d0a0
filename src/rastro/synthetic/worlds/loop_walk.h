// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/synthetic/path.h"

namespace rastro::loop {

constexpr double rate_hz = 20.0, speed = 1.6, camera_height_m = 1.6;

/// A place on the way and where it leads there.
struct WayPoint {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< Metres.
  double heading = 0.0;                             ///< Radians from the x axis to the left, without jumps.
};

/// Length of the whole way, and of the part that leads back to the start.
double way_m();
double round_m();
/// At a way (metres) from the start; the ends where it is beyond them.
WayPoint way_point(double way);

/// The camera in the hand of somebody who walks it, with the cut to another place.
CameraPath walk_path();

}  // namespace rastro::loop
