// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

struct LoopOptions {
  std::uint64_t seed = 1;  ///< Of textures, things along the way and noise. Walls, way and crowd stay the same.
  double scale = 1.0;      ///< Size of the picture relative to 640 x 480.
  int threads = 0;         ///< For painting the textures; 0 = all of the machine. The result does not depend on it.
};

/// A walk of 120 m through streets, a hall and a square with a stereo camera in the hand (640x480, f = 420, 20 Hz, the
/// right camera 0.12 m beside the left one). The first 68 m lead around a block of houses and back to the start, which
/// is walked again in the same direction; the end crosses the square against the direction of the first visit, the
/// camera at its houses both times. A crowd is met on the way, and for two seconds the pictures are of another place.
/// The camera stands still after the walk.
World make_loop(const LoopOptions& options = {});

// What happens when, in frames: [begin, end).
constexpr std::int64_t loop_frames = 1541;                                    ///< The walk.
constexpr std::int64_t loop_crowd_begin = 210, loop_crowd_end = 420;          ///< People in front of the camera.
constexpr std::int64_t loop_elsewhere_begin = 550, loop_elsewhere_end = 590;  ///< Then the walk goes on where it was.

}  // namespace rastro
