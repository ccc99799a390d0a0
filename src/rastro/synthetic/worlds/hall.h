// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

struct HallOptions {
  std::uint64_t seed = 1;  ///< Of textures, furniture and noise. The trajectory and the occlusions stay the same.
  double scale = 1.0;      ///< Size of the image relative to 752 x 480.
  /// With the radial-tangential distortion of EuRoC's left camera; else an undistorted pinhole.
  bool distortion = false;
  int threads = 0;  ///< Threads for painting the textures; 0: all cores. The result does not depend on it.
};

/// A machine hall seen from a drone at 20 Hz, modeled on EuRoC's machine hall (Burri et al. 2016). In the first 30
/// frames the drone rises behind a press and sinks again: most of the upper half of the first image is occluded for 8
/// to 15 frames and reappears. Frames 42-56: an abrupt rotation and back. Frames 76-112: a pillar passes in front. Then
/// an endless tour.
World make_hall(const HallOptions& options = {});

}  // namespace rastro
