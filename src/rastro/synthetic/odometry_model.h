// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numbers>

#include "rastro/base/random.h"
#include "rastro/math/se2.h"

namespace rastro {

/// Error model of wheel odometry. The two sizes are root mean squares over many robots: the error after one meter or an
/// eighth of a rotation. Part of it is a scale that is constant for a whole drive, with a random sign; the rest is
/// drawn for every piece of the path.
struct OdometryModel {
  double error_per_meter = 0.02;                             ///< Meters, after 1 m.
  double error_per_eighth = 2.0 * std::numbers::pi / 180.0;  ///< Radians, after a rotation of 45 degrees.
  double constant_share = 0.7;                               ///< Share of the error due to the constant scale.
  double factor = 1.0;                                       ///< Multiplies both errors.
};

/// Wheel odometry of one drive. The errors depend on path length and rotation, not on the size of the steps.
class WheelOdometry {
 public:
  /// Throws Error if the factor is negative or NaN.
  WheelOdometry(const OdometryModel& model, std::uint64_t seed);

  /// Takes the true motion since the last call and returns the pose by odometry, relative to the start.
  const SE2& move(const SE2& before_from_body);
  const SE2& odometry_from_body() const { return odometry_from_body_; }

 private:
  OdometryModel model_;
  Random random_;
  double meter_scale_, rotation_scale_;
  SE2 odometry_from_body_;
};

}  // namespace rastro
