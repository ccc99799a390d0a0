// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

struct StreetOptions {
  std::uint64_t seed = 1;  ///< Of textures, houses, trees and noise. The way and the moving cars' ways stay the same.
  double scale = 1.0;      ///< Size of the picture relative to 1242 x 375.
  int threads = 0;         ///< For painting the textures; 0 = all of the machine. The result does not depend on it.
};

/// A drive around a block of houses at 10 Hz, in the manner of KITTI (Geiger et al. 2013): its left grey camera,
/// rectified, 1.65 m above the road. Frames 6-43: a turn to the left; then a straight with traffic, a second turn
/// (about frames 210-250) and another straight; the block goes on without end, a lap takes about 78 s. The exposure
/// changes, other cars drive and are parked. The body is KITTI's GPS/IMU unit (x forward, y left, z up).
World make_street(const StreetOptions& options = {});

}  // namespace rastro
