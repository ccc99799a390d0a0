// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/synthetic/frame_selection.h"
#include "rastro/synthetic/world.h"

namespace rastro {

/// Loop closure: two frames, far apart in time, that show the same objects.
struct TrueLoopClosure {
  std::int64_t frame = 0, earlier = 0;  ///< Numbers in the recording.
  double overlap = 0.0;                 ///< Share of the pixels of `frame` whose surface is visible in `earlier`.
  double distance_m = 0.0;              ///< Between the camera's two positions.
  bool opposite = false;                ///< The camera moves in the opposite direction (more than 90 degrees).
};

struct LoopClosureSearch {
  double step_s = 0.5;      ///< Only frames this far apart are used, on both sides.
  double gap_s = 15.0;      ///< Minimum distance in time.
  double farthest_m = 5.0;  ///< Maximum distance of the positions
  double widest_rad = 0.8;  ///< and maximum angle of the viewing directions.
  double least_overlap = 0.3;
  double farthest_point_m = 40;  ///< Points farther than this (sky) do not identify a place.
};

/// For each used frame of a recording the earlier one with the largest overlap, exact from the scene, in the order of
/// time; moving objects are at their poses of each frame's own time. The same for any pool.
std::vector<TrueLoopClosure> true_loop_closures(const World& world, std::int64_t frames,
                                                const FrameSelection& selection, TaskPool& pool,
                                                const LoopClosureSearch& search = {});

/// Writes closures.yaml to the folder of a recording: true_loop_closures() with frame numbers and stamps. Throws Error
/// if it cannot be written.
void write_loop_closures(const World& world, std::int64_t frames, const FrameSelection& selection,
                         const std::filesystem::path& folder, TaskPool& pool);

}  // namespace rastro
