// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/laser_world.h"
#include "rastro/synthetic/world.h"

namespace rastro {

struct CorridorOptions {
  std::uint64_t seed = 1;  ///< Of furniture, door leaves, textures and noise. The walls and all ways stay the same.
  double scale = 1.0;      ///< Size of the camera's picture relative to 640 x 480.
  int threads = 0;         ///< For painting the textures; 0 = all of the machine. The result does not depend on it.
};

/// An office floor: corridors in a rectangle of 28 m x 8 m around a block of rooms, doors open, closed and of glass,
/// and in the north 26 m of bare walls on both sides, of which a laser that looks 10 m far and not behind itself sees
/// no end for 16 m. The robot drives once around, through a meeting room, and 10 m farther: 86 m at up to 0.55 m/s. A
/// person crosses its way and comes towards it. The laser looks 270 degrees around, 0.35 m above the floor, 10 times a
/// second.
LaserWorld make_corridor_floor(const CorridorOptions& options = {});

/// The same drive seen by a camera 0.8 m above the floor that looks ahead; glass is perfectly clear to it. The body is
/// the robot (x forward, y left, z up, on the floor).
World make_corridor(const CorridorOptions& options = {});

}  // namespace rastro
