// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/synthetic/path.h"

namespace rastro::street {

constexpr double rate_hz = 10.0;
constexpr double camera_height_m = 1.65;

// A block of houses with a street on each side. The center lines of the streets are x = 0, x = block_x, y = 0 and y =
// block_y (meters); they cross and continue for street_beyond. Traffic keeps to the right.
constexpr double block_x = 150.0, block_y = 150.0, street_beyond = 62.0;
constexpr double lane = 3.3;  ///< Width; two to a street, and parked cars on both sides of them.

/// A position in the plane and the car's heading there.
struct PlanPose {
  double x = 0.0, y = 0.0;  ///< Meters.
  double heading = 0.0;     ///< Radians from the x axis to the left.
};

/// Trajectory of the car around the block: four straights and four turns to the left, over and over. It starts a few
/// meters before the first turn and drives at the speeds of town traffic: 4.6 m/s in turns, about 9 m/s on straights.
class Drive {
 public:
  Drive();

  double lap_m() const { return lap_m_; }
  double lap_s() const { return lap_s_; }
  /// Path length since the start at any time, negative before 0.
  double path_at(double time_s) const;
  double speed_at(double time_s) const;
  PlanPose pose_at_distance(double path_m) const;
  /// Curvature of the path (1/m) at a path length: 0 on straights.
  double curvature_at_distance(double path_m) const;

 private:
  double wanted_speed(double path_m) const;

  double turn_reach_ = 0.0;  ///< From a corner of the lane to the begin and end of its turn.
  double straight_m_[2] = {0.0, 0.0};
  double lap_m_ = 0.0, lap_s_ = 0.0;
  std::vector<PlanPose> turn_;     ///< Evenly spaced along one turn that begins at the origin along x.
  std::vector<double> distances_;  ///< Evenly spaced in time over one lap.
};

/// The camera on the roof of that car, with a little pitch and roll.
CameraPath drive_path();

}  // namespace rastro::street
