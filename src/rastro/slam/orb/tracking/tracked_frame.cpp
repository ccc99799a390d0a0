// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/tracked_frame.h"

namespace rastro {

TrackedFrame tracked_frame(const MapGraph& graph, const MapView& view, const FeatureFrame& frame,
                           const TrackingResult& tracked, double pixel_sigma) {
  const MapView::Keyframe& reference = view.keyframe(tracked.reference);
  TrackedFrame result{frame.data().frame,
                      frame.data().stamp,
                      reference.id,
                      tracked.camera_from_world * reference.camera_from_world.inverse(),
                      reference.unit,
                      -1,
                      {},
                      tracked.direct};
  for (const TrackedPoint& point : tracked.points) {
    if (point.landmark < 0) continue;
    result.seen.push_back({point.landmark, frame.ray(point.feature).cast<float>(),
                           static_cast<float>(frame.right_ray(point.feature)),
                           static_cast<float>(pixel_sigma * graph.sigma(frame, point.feature))});
  }
  return result;
}

TrackedFrame tracked_keyframe(const MapGraph& graph, const FeatureFrame& frame, std::int64_t keyframe) {
  return {frame.data().frame, frame.data().stamp, keyframe, SE3(), graph.unit(keyframe), keyframe, {}};
}

}  // namespace rastro
