// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/final_map.h"

#include <algorithm>

#include "rastro/map/graph/planar.h"
#include "rastro/map/scans/scan_layer.h"

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

Trajectory scan_trajectory(const std::vector<PosedScan>& scans, const SubmapGraph& graph) {
  Trajectory trajectory;
  for (const StampedPlanarPose& pose : scan_poses(scans, graph))
    trajectory.push_back({pose.stamp, in_space(pose.pose)});
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  return trajectory;
}

std::shared_ptr<const Map> map_of_scans(const std::vector<PosedScan>& scans, const SubmapGraph& graph,
                                        const HectorOptions& options, std::int64_t revision) {
  auto map = std::make_shared<Map>();
  map->method = "hector";
  map->revision = revision;
  auto layer = std::make_shared<ScanLayer>();
  layer->cell_m = options.cell_m;
  layer->model = {options.occupied_probability, options.free_probability};
  for (std::size_t k = 0; k < graph.key_scans().size(); ++k) {
    const KeyScan& key_scan = graph.key_scans()[k];
    const auto id = static_cast<KeyframeId>(k);
    map->keyframes.push_back(
        {id, key_scan.frame, key_scan.stamp, 0, in_space(graph.world_from_key_scan(k)), 0, id - 1, 1.0});
    layer->of[id] = std::make_shared<KeyframeScans>(1, key_scan.scan);
  }
  map->layers.put<ScanLayer>(std::move(layer));
  map->constraints = graph.constraints();
  const std::vector<StampedPlanarPose> poses = scan_poses(scans, graph);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::size_t key = scans[i].key_scan;
    map->frames.push_back({poses[i].stamp, static_cast<KeyframeId>(key),
                           in_space(graph.world_from_key_scan(key).inverse() * poses[i].pose)});
  }
  const TimeNs first = scans.empty() ? 0 : scans.front().stamp, last = scans.empty() ? 0 : scans.back().stamp;
  map->sessions.push_back({0, 0, "", first, last, {true, 0.0, "laser"}});
  return map;
}

}  // namespace rastro
