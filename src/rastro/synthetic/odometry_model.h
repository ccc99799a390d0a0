// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numbers>

#include "rastro/base/random.h"
#include "rastro/math/se2.h"

namespace rastro {

/// How wrong wheels count. The two sizes are root mean squares over many robots: what one metre or an eighth of a turn
/// is off. Part of it is a scale that stays the same for a whole drive, with a sign drawn once; the rest is drawn anew
/// for every bit of the way.
struct OdometryModel {
  double error_per_metre = 0.02;                             ///< Metres, after 1 m.
  double error_per_eighth = 2.0 * std::numbers::pi / 180.0;  ///< Radians, after 45 degrees of turn.
  double constant_share = 0.7;                               ///< Of the error, by size, that is the constant scale.
  double factor = 1.0;                                       ///< On both errors.
};

/// Counts the motion of one drive. The errors depend on way and turn, not on how finely the drive is cut into steps.
class WheelOdometry {
 public:
  /// Error for a factor that is negative or no number.
  WheelOdometry(const OdometryModel& model, std::uint64_t seed);

  /// Takes the true motion since the last call and returns where the wheels say the body is, from the start.
  const SE2& move(const SE2& before_from_body);
  const SE2& odometry_from_body() const { return odometry_from_body_; }

 private:
  OdometryModel model_;
  Random random_;
  double metre_scale_, turn_scale_;
  SE2 odometry_from_body_;
};

}  // namespace rastro
