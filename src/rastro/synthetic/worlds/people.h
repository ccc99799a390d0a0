// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "rastro/synthetic/scene.h"

namespace rastro {

/// Adds a walking person in a coat of this tone as moving objects: the body at `pose` (x ahead, z up from the floor),
/// the legs swinging with `phase` (radians).
void add_person(Scene& scene, const Motion& pose, double phase, float coat);

/// Position on a straight walk to and fro at a time, and the direction of the motion there.
struct Stroll {
  Eigen::Vector3d from, to;
  double speed = 1.0;    ///< m/s
  double start_m = 0.0;  ///< Position on the walk there and back at time 0.

  SE3 pose(double time_s) const;
};

}  // namespace rastro
