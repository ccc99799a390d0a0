// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

struct HallOptions {
  std::uint64_t seed = 1;   ///< Of textures, furniture and noise. The path and what hides what stay the same.
  double scale = 1.0;       ///< Size of the picture relative to 752 x 480.
  bool distortion = false;  ///< With the radial-tangential distortion of EuRoC's left camera; else an ideal pinhole.
  int threads = 0;          ///< For painting the textures; 0 = all of the machine. The result does not depend on it.
};

/// A machine hall seen from a drone at 20 Hz, in the manner of EuRoC's machine hall (Burri et al. 2016). In the first
/// 30 frames the drone rises behind a press and sinks again: most of the upper half of the first picture is hidden for
/// 8 to 15 frames and comes back. Frames 42-56: an abrupt turn and back. Frames 76-112: a pillar passes in front. Then
/// a tour that never ends.
World make_hall(const HallOptions& options = {});

}  // namespace rastro
