// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rastro/map/graph/map.h"
#include "rastro/slam/orb/map/frame_trajectory.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// What a map that is continued had besides its graph.
struct GivenMap {
  MapScale scale;
  FrameTrajectory trajectory;             ///< Frames of earlier runs.
  std::vector<MapSession> sessions = {};  ///< These runs.
};

/// Exports the map of a method of that name. The submap with most frames is renumbered to 0, but that of a given map
/// stays 0, with its scale and the frames of earlier runs.
std::shared_ptr<const Map> map_of(const MapGraph& graph, const FrameTrajectory& trajectory,
                                  const std::optional<GivenMap>& given, const std::string& method = "orb");
/// Fills an empty graph with an existing map.
GivenMap restore(const Map& map, double baseline, MapGraph& graph);

}  // namespace rastro
