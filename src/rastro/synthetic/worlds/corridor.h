// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/laser_world.h"
#include "rastro/synthetic/world.h"

namespace rastro {

struct CorridorOptions {
  /// Of furniture, door leaves, textures and noise. The walls and all trajectories stay the same.
  std::uint64_t seed = 1;
  double scale = 1.0;  ///< Size of the camera's image relative to 640 x 480.
  int threads = 0;     ///< Threads for painting the textures; 0: all cores. The result does not depend on it.
};

/// An office floor: corridors in a rectangle of 28 m x 8 m around a block of rooms, with doors open, closed and of
/// glass. In the north there are 26 m of bare walls on both sides; for 16 m of them, a laser with a range of 10 m and
/// no view to the rear sees neither end. The robot drives once around, through a meeting room, and 10 m farther: 86 m
/// at up to 0.55 m/s. A person crosses its path and walks towards it. The laser covers 270 degrees, 0.35 m above the
/// floor, 10 times a second.
LaserWorld make_corridor_floor(const CorridorOptions& options = {});

/// The same drive with a forward-looking camera 0.8 m above the floor; glass is perfectly clear to it. The body is the
/// robot (x forward, y left, z up, on the floor).
World make_corridor(const CorridorOptions& options = {});

}  // namespace rastro
