// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "rastro/slam/orb/keyframe_pipeline.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/frame_testing.h"
#include "rastro/slam/orb/tracking/keyframe_insertion.h"

namespace rastro::testing {

/// For tests only: a recording of this camera.
inline SourceInfo source_of(const Camera& camera, CameraKind sensor) {
  SourceInfo source;
  source.path = "test";
  source.cameras = {{"camera", camera, {}, ""}};
  source.has_depth = sensor == CameraKind::depth;
  return source;
}

/// The parts of a run over a PointWorld, without images: session, tracker, pipeline and an exact map in the session's
/// graph.
struct SessionBench {
  explicit SessionBench(CameraKind sensor, const OrbSlamOptions& options = {}, const SlamContext& context = {},
                        PointWorld points = PointWorld(300, 5))
      : world(std::move(points)),
        session(options, source_of(world.camera, sensor), context),
        tracker(session.options, session.sensor.camera, session.sensor.sensor, session.sensor.baseline),
        pipeline(session, tracker, context),
        keyframes(session, tracker, pipeline),
        map(world, session.graph) {}

  /// 0.2 m to the right of the previous one.
  static SE3 stop(double k) { return SE3(SO3(), {-0.2 * k, 0.0, 0.0}); }

  /// A map of keyframes at the first `count` stops, tracked from the last of them.
  void begin(int count, const ObserveOptions& how = {}) {
    for (int k = 0; k < count; ++k) map.add(k, stop(k), how);
    session.next_keyframe = count;
    session.has_map = session.tracking = true;
    stand_at(count - 1, how);
  }
  /// Centers the tracker's view at the keyframe and restarts tracking at its pose.
  void stand_at(std::int64_t keyframe, const ObserveOptions& how = {}) {
    tracker.set_view(view_of(session.graph, keyframe, session.view_options()));
    const SE3 pose = session.graph.camera_from_world(keyframe);
    const Observed observed = observe(keyframe, pose, how);
    tracker.restart(pose, map.tracked(observed), observed.frame);
  }
  Observed observe(std::int64_t index, const SE3& camera_from_world, ObserveOptions how = {}) const {
    how.baseline = session.sensor.baseline;
    return world.observe(index, camera_from_world, how);
  }
  /// The tracking result for a frame.
  TrackingResult tracked(const Observed& observed, const SE3& camera_from_world, std::int64_t reference) const {
    TrackingResult result;
    result.ok = true;
    result.camera_from_world = camera_from_world;
    result.points = map.tracked(observed);
    result.matches = result.inliers = static_cast<int>(result.points.size());
    result.reference = reference;
    return result;
  }
  /// A frame at `stop(k)` as the next keyframe, as it is handed to the pipeline.
  std::shared_ptr<const KeyframeInput> input(std::int64_t index, double k, std::int64_t reference,
                                             const ObserveOptions& how = {}) {
    const Observed observed = observe(index, stop(k), how);
    KeyframeInput made;
    made.frame = observed.frame->with_id(session.next_keyframe++);
    made.reference = reference;
    made.camera_from_reference = stop(k) * session.graph.camera_from_world(reference).inverse();
    made.points = map.tracked(observed);
    return std::make_shared<const KeyframeInput>(std::move(made));
  }

  PointWorld world;
  OrbSession session;
  FrameTracker tracker;
  KeyframePipeline pipeline;
  KeyframeInsertion keyframes;
  ExactMap map;
};

}  // namespace rastro::testing
