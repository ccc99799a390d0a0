// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro {

/// The session of each keyframe, an index into those of the map: the one in its id, or where a method numbers all
/// keyframes on, the next as soon as their stamps jump back or leave the span of one. nullopt where there is none.
std::vector<std::optional<std::size_t>> sessions_of_keyframes(const Map& map);

/// The session of each frame, which may be relative to a keyframe of an earlier one: the next as soon as the stamps
/// jump back or leave the span of one. 0 where the map names no session.
std::vector<std::size_t> sessions_of_frames(const Map& map);

/// Whether two sessions have poses at the same time, as recordings do whose clocks begin at 0: in the order of time,
/// their poses would jump back and forth between both.
bool sessions_overlap(const Map& map);

/// As trajectory_of(), of the frames of one session.
Trajectory trajectory_of_session(const Map& map, std::size_t session, int submap = 0);

}  // namespace rastro
