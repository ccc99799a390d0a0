// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

struct RoomOptions {
  /// Of textures, small objects and noise. The known lengths and the trajectory stay the same.
  std::uint64_t seed = 1;
  double scale = 1.0;  ///< Size of the image relative to 640 x 480.
  int threads = 0;     ///< Threads for painting the textures; 0: all cores. The result does not depend on it.
};

/// A small bedroom with few objects in artificial light, seen by a hand-held Kinect at 30 Hz: a shelf with a blue box
/// (0.32 x 0.25 m), mostly seen from the front, and a bed 2 m long that is only ever seen at an angle. The camera
/// walks, is swung away at bedroom_swing_s, looks around and is back at the start after bedroom_round_s; then it
/// continues without end.
World make_bedroom(const RoomOptions& options = {});
constexpr double bedroom_round_s = 38.5, bedroom_swing_s = 15.0;

/// The same for a study with many objects in less light: a shelf 0.16 m high, another 0.75 m wide, a wall calendar 0.42
/// m high, and a glass table 0.85 m wide.
World make_study(const RoomOptions& options = {});
constexpr double study_round_s = 38.5, study_swing_s = 20.5;

}  // namespace rastro
