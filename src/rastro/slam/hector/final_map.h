// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/map/graph/map.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/trajectory.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap_graph.h"

namespace rastro {

/// The pose of a scan as the matcher estimated it, and the key scan before it.
struct PosedScan {
  TimeNs stamp = 0;
  std::size_t key_scan = 0;
  SE2 local_from_body;
};

struct StampedPlanarPose {
  TimeNs stamp = 0;
  SE2 pose;
};

/// Every scan in the world. The correction between two key scans is interpolated in proportion to time.
std::vector<StampedPlanarPose> scan_poses(const std::vector<PosedScan>& scans, const SubmapGraph& graph);

/// The same in the order of their stamps, which in some logs is not that of the scans.
Trajectory scan_trajectory(const std::vector<PosedScan>& scans, const SubmapGraph& graph);

/// The key scans with their constraints, and every scan relative to one.
std::shared_ptr<const Map> map_of_scans(const std::vector<PosedScan>& scans, const SubmapGraph& graph,
                                        const HectorOptions& options, std::int64_t revision);

}  // namespace rastro
