// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/map/snapshot.h"
#include "rastro/slam/orb/frame_way.h"
#include "rastro/slam/orb/map_graph.h"

namespace rastro {

/// The map as others read it. The submap with most frames is called 0.
std::shared_ptr<const LandmarkMap> landmark_map_of(const MapGraph& graph, const FrameWay& way);
/// With keyframes and edges of that map.
std::shared_ptr<const Snapshot> snapshot_of(const MapGraph& graph, const FrameWay& way);

}  // namespace rastro
