// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/tracked_frame.h"

#include <utility>

namespace rastro {

TrackedFrame tracked_frame(const MapGraph& graph, const MapView& view, const FeatureFrame& frame,
                           const TrackingResult& tracked, double pixel_sigma) {
  const MapView::Keyframe& reference = view.keyframe(tracked.reference);
  auto measured = std::make_shared<FrameMeasurements>();
  measured->direct = tracked.direct;
  measured->seen.reserve(tracked.points.size());
  for (const TrackedPoint& point : tracked.points) {
    if (point.landmark < 0) continue;
    measured->seen.push_back({point.landmark, frame.ray(point.feature).cast<float>(),
                              static_cast<float>(frame.right_ray(point.feature)),
                              static_cast<float>(pixel_sigma * graph.sigma(frame, point.feature))});
  }
  if (measured->seen.empty()) measured.reset();
  return {frame.data().frame,
          frame.data().stamp,
          reference.id,
          reference.unit,
          tracked.camera_from_world * reference.camera_from_world.inverse(),
          -1,
          std::move(measured)};
}

TrackedFrame tracked_keyframe(const MapGraph& graph, const FeatureFrame& frame, std::int64_t keyframe) {
  return {frame.data().frame, frame.data().stamp, keyframe, graph.unit(keyframe), SE3(), keyframe, {}};
}

}  // namespace rastro
