// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

struct StreetOptions {
  std::uint64_t seed = 1;  ///< Of textures, houses, trees and noise. The trajectories of the camera and of the moving
                           ///< cars stay the same.
  double scale = 1.0;      ///< Size of the image relative to 1242 x 375.
  int threads = 0;         ///< Threads for painting the textures; 0: all cores. The result does not depend on it.
};

/// A drive around a block of houses at 10 Hz, modeled on KITTI (Geiger et al. 2013): its left gray camera, rectified,
/// 1.65 m above the road. Frames 6-43: a turn to the left; then a straight with traffic, a second turn (about frames
/// 210-250) and another straight; the drive continues without end, a lap takes about 78 s. The exposure changes; other
/// cars drive or are parked. The body is KITTI's GPS/IMU unit (x forward, y left, z up).
World make_street(const StreetOptions& options = {});

}  // namespace rastro
