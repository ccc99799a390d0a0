// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "rastro/map/graph/map.h"
#include "rastro/slam/orb/map/frame_trajectory.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// Exports the map. The submap with most frames is renumbered to 0. `scale`: the scale of its unit, where known.
std::shared_ptr<const Map> map_of(const MapGraph& graph, const FrameTrajectory& trajectory,
                                  const std::optional<MapScale>& scale);
/// Fills an empty graph with an existing map.
void restore(const Map& map, double baseline, MapGraph& graph);

}  // namespace rastro
