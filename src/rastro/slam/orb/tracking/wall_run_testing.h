// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "rastro/slam/orb/session_testing.h"
#include "rastro/slam/orb/tracking/tracking.h"
#include "rastro/slam/orb/tracking/wall_testing.h"

namespace rastro::testing {

/// For tests only.
inline Camera wall_camera() {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 230.0;
  camera.cx = 162.0;
  camera.cy = 118.0;
  return camera;
}

/// For tests only: the parts of a run, in front of a wall seen by a depth camera.
struct WallRun {
  explicit WallRun(const OrbSlamOptions& options = wall_options(), const Camera& camera = wall_camera(),
                   CameraKind sensor = CameraKind::depth)
      : session(options, source_of(camera, sensor), {}),
        tracker(session.options, session.sensor.camera, session.sensor.sensor, session.sensor.baseline),
        pipeline(session, tracker, {}),
        tracking(session, tracker, pipeline, nullptr) {}

  static OrbSlamOptions wall_options() {
    OrbSlamOptions options;
    options.features = 400;
    options.virtual_baseline_m = 0.1;
    options.far_baselines = 100.0;
    return options;
  }
  /// Frame k is taken at 0.1 k s.
  static Frame frame_at(std::int64_t index, const SE3& world_from_camera) {
    Frame frame;
    frame.index = index;
    frame.stamp = frame.depth_stamp = 100000000 * index;
    frame.image = image_of_wall(wall_camera(), world_from_camera);
    frame.depth = depth_from(world_from_camera.translation().z());
    return frame;
  }
  static DepthImage depth_from(double z) {
    DepthImage depth(wall_camera().width, wall_camera().height);
    for (int y = 0; y < depth.height(); ++y) std::fill_n(depth.row(y), depth.width(), static_cast<float>(wall_m - z));
    return depth;
  }
  SlamUpdate process(const Frame& frame) {
    SlamUpdate update;
    update.world_from_body = last_pose;
    ++session.frame_number;
    tracking.process(frame, update);
    last_pose = update.world_from_body;
    return update;
  }
  SlamUpdate process(std::int64_t index, double x) { return process(frame_at(index, beside(x))); }
  static SE3 beside(double x) { return SE3(SO3(), {x, 0.0, 0.0}); }

  OrbSession session;
  FrameTracker tracker;
  KeyframePipeline pipeline;
  Tracking tracking;
  SE3 last_pose;
};

inline std::size_t count_of(const std::vector<FeatureObservation>& observations, ObservationState state) {
  return static_cast<std::size_t>(
      std::count_if(observations.begin(), observations.end(), [&](const auto& o) { return o.state == state; }));
}

}  // namespace rastro::testing
