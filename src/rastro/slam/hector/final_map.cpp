// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/final_map.h"

#include <algorithm>

namespace rastro {

std::vector<StampedPlanarPose> scan_poses(const std::vector<PosedScan>& scans, const SubmapGraph& graph) {
  std::vector<StampedPlanarPose> poses;
  const std::vector<KeyScan>& keys = graph.key_scans();
  const auto world_by = [&](std::size_t key, const SE2& local_from_body) {
    return graph.world_from_key_scan(key) * keys[key].local_from_body.inverse() * local_from_body;
  };
  for (const PosedScan& scan : scans) {
    if (keys.empty()) continue;
    const SE2 by_last = world_by(scan.key_scan, scan.local_from_body);
    const std::size_t next = scan.key_scan + 1;
    if (next >= keys.size() || scan.stamp <= keys[scan.key_scan].stamp) {
      poses.push_back({scan.stamp, by_last});
      continue;
    }
    const double fraction = static_cast<double>(scan.stamp - keys[scan.key_scan].stamp) /
                            static_cast<double>(keys[next].stamp - keys[scan.key_scan].stamp);
    poses.push_back(
        {scan.stamp, interpolate(by_last, world_by(next, scan.local_from_body), std::clamp(fraction, 0.0, 1.0))});
  }
  return poses;
}

}  // namespace rastro
