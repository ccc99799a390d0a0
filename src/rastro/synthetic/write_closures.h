// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "rastro/synthetic/world.h"

namespace rastro {

/// Two frames, far apart in time, that show the same things.
struct TrueClosure {
  std::int64_t frame = 0, earlier = 0;
  double overlap = 0.0;     ///< Share of the pixels of `frame` whose surface is in sight in `earlier`.
  double distance_m = 0.0;  ///< Between the camera's two places.
  bool opposite = false;    ///< The camera moves the other way (more than 90 degrees) than it did then.
};

struct ClosureSearch {
  std::int64_t step = 10;   ///< Every so many frames are looked at, and compared with every so many.
  std::int64_t gap = 300;   ///< Frames nearer in time than this are no closure.
  double farthest_m = 5.0;  ///< Nor are frames taken from places farther apart than this,
  double widest_rad = 0.8;  ///< or in directions more different.
  double least_overlap = 0.3;
  double farthest_point_m = 40;  ///< Sky and what else is far does not tell a place.
};

/// For each frame looked at the earlier one that shows most of the same, exactly as the scene has it, in the order of
/// time; things that move are taken to be where they are at each frame's own time.
std::vector<TrueClosure> true_closures(const World& world, std::int64_t frames, const ClosureSearch& search = {});

/// Writes closures.yaml into the folder of a recording: true_closures() with frame numbers and stamps. Error where it
/// cannot be written.
void write_closures(const World& world, std::int64_t frames, const std::filesystem::path& folder);

}  // namespace rastro
