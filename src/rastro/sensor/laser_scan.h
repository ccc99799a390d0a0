// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "rastro/math/se2.h"

namespace rastro {

/// One scan of a 2D laser. The laser frame: x forward, y left, angles counter-clockwise from x.
struct LaserScan {
  double first_angle = 0.0;   ///< Radians, of ranges[0].
  double angle_step = 0.0;    ///< Radians from one beam to the next; negative for a scanner mounted upside down.
  double min_range = 0.0;     ///< Meters; a closer return is the scanner's own housing or noise.
  double max_range = 0.0;     ///< Meters; at or beyond it there was no return.
  std::vector<float> ranges;  ///< Meters, one per beam; may have any value: check is_return().
  SE2 body_from_laser;

  bool is_return(std::size_t beam) const {
    const double range = static_cast<double>(ranges[beam]);
    return std::isfinite(range) && range > min_range && range < max_range;
  }
  /// No return within range in this direction: the beam went through free space up to max_range. False for a broken
  /// beam.
  bool is_free(std::size_t beam) const {
    const double range = static_cast<double>(ranges[beam]);
    return range >= max_range;
  }
  double angle_of(std::size_t beam) const { return first_angle + static_cast<double>(beam) * angle_step; }
};

/// Observation of a landmark: range and bearing in the body frame.
struct LandmarkMeasurement {
  std::int64_t id = -1;  ///< Of the landmark if the sensor identifies it, else -1.
  double range = 0.0;    ///< Meters.
  double bearing = 0.0;  ///< Radians, counter-clockwise from the body's x.
};

/// Measurement of an IMU at one instant, in its own frame.
struct ImuSample {
  std::int64_t stamp = 0;                                      ///< ns
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< rad/s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();      ///< m/s^2, gravity included
};

}  // namespace rastro
