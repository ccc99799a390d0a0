// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

struct LoopOptions {
  /// Of textures, objects along the path and noise. Walls, trajectory and crowd stay the same.
  std::uint64_t seed = 1;
  double scale = 1.0;  ///< Size of the image relative to 640 x 480.
  int threads = 0;     ///< Threads for painting the textures; 0: all cores. The result does not depend on it.
};

/// A walk of 120 m through streets, a hall and a square with a hand-held stereo camera (640x480, f = 420, 20 Hz, the
/// right camera 0.12 m beside the left one). The first 68 m lead around a block of houses and back to the start; then
/// the first street is walked again in the same direction. The end crosses the square against the direction of the
/// first visit, with the camera facing its houses both times. The walk passes a crowd, and for two seconds the images
/// show another place (kidnap). The camera is at rest after the walk.
World make_loop(const LoopOptions& options = {});

// Events in frames: [begin, end).
constexpr std::int64_t loop_frames = 1541;                                    ///< The walk.
constexpr std::int64_t loop_crowd_begin = 210, loop_crowd_end = 420;          ///< People in front of the camera.
constexpr std::int64_t loop_elsewhere_begin = 550, loop_elsewhere_end = 590;  ///< Then the walk continues where it was.

}  // namespace rastro
