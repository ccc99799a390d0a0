// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/synthetic/world.h"

namespace rastro {

struct CampusOptions {
  /// Of textures, notices, furniture, cars, people, light and noise. Walls and trajectory stay the same.
  std::uint64_t seed = 1;
  double scale = 1.0;  ///< Size of the image relative to 640 x 480.
  int threads = 0;     ///< Threads for painting the textures; 0: all cores. The result does not depend on it.
};

/// A tour of 30 minutes with a body camera (640x480, f = 420, 20 Hz, the right camera 0.12 m beside the left one):
/// three laps of 600 m through a parking lot, the corridors of a ground floor, a courtyard, up a flight of stairs, the
/// corridors of the upper floor, down another flight and around the building. Corridors look alike on both floors and
/// in both wings; door signs, posters and notice boards differ. From lap to lap the light changes, and a third of the
/// furniture and of the parked cars moves, comes or goes. People walk everywhere. The camera is at rest after the tour.
World make_campus(const CampusOptions& options = {});

constexpr std::int64_t campus_frames = 36000;  ///< The tour.

}  // namespace rastro
