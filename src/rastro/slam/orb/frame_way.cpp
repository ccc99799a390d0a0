// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/frame_way.h"

#include <algorithm>

namespace rastro {

void FrameWay::add(const PlacedFrame& frame) {
  const auto at = std::upper_bound(frames_.begin(), frames_.end(), frame.index,
                                   [](std::int64_t index, const PlacedFrame& other) { return index < other.index; });
  frames_.insert(at, frame);
}

Trajectory FrameWay::trajectory(const MapGraph& graph, int submap) const {
  Trajectory way;
  for (const PlacedFrame& frame : frames_) {
    if (graph.submap(frame.keyframe) != submap) continue;
    const double scale = graph.unit(frame.keyframe) / frame.unit;
    const SE3 from_keyframe(frame.camera_from_keyframe.rotation(), scale * frame.camera_from_keyframe.translation());
    way.push_back({frame.stamp, (from_keyframe * graph.camera_from_world(frame.keyframe)).inverse()});
  }
  return way;
}

int FrameWay::largest_submap(const MapGraph& graph) const {
  std::vector<int> counts(static_cast<std::size_t>(std::max(1, graph.submap_count())), 0);
  for (const PlacedFrame& frame : frames_) ++counts[static_cast<std::size_t>(graph.submap(frame.keyframe))];
  return static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

}  // namespace rastro
