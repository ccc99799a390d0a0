// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rastro/synthetic/path.h"

namespace rastro::room {

constexpr double rate_hz = 30.0;

/// Hand-held camera pose at a time of the first round: x y z (meters), yaw (to the left), pitch (down) and roll in
/// degrees.
struct WalkKey {
  double time_s;
  std::array<double, 6> pose;
};

/// A walk through a room that returns to its start and continues without end.
struct Walk {
  std::vector<WalkKey> keys;  ///< The first at time 0; the last equals the first.
  double swing_s = 0.0;       ///< Start of the swing: away within 0.4 s, and back after a moment.
  double swing_degrees = 52.0;
  double wander_m = 0.05;  ///< Deviation of later rounds from the first one.
};

/// A round lasts as long as the keys. Each later round is a little different; the swing happens once. The hand is never
/// still.
CameraPath walk_path(const Walk& walk);

}  // namespace rastro::room
