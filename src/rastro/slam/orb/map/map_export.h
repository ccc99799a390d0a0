// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "rastro/map/graph/map.h"
#include "rastro/slam/orb/map/frame_trajectory.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// The map as others read it. The submap with most frames is called 0. `scale`: what its unit is worth, where somebody
/// said so.
std::shared_ptr<const Map> map_of(const MapGraph& graph, const FrameTrajectory& way,
                                  const std::optional<MapScale>& scale);
/// Fills an empty graph with a map made before.
void restore(const Map& map, double baseline, MapGraph& graph);

}  // namespace rastro
