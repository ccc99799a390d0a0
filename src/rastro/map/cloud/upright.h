// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/map/cloud/point_cloud.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// A frame with z up and its origin on the floor below the first camera, which faces along x.
struct Upright {
  SE3 upright_from_world;
  bool floor_found = false;
  std::string found_by;  ///< One clause, human-readable.
};

/// A depth camera does not measure gravity. Down is initially the mean of the cameras' y axes, then the normal of the
/// lowest large plane roughly perpendicular to it. Without such a plane the origin is at the first camera itself.
/// `cameras` is world_from_camera.
Upright find_upright(const PointCloud& cloud, const Trajectory& cameras);

}  // namespace rastro
