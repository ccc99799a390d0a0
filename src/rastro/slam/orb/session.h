// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "rastro/backend/pipeline.h"
#include "rastro/slam/orb/map/frame_trajectory.h"
#include "rastro/slam/orb/map/map_graph.h"
#include "rastro/slam/orb/map/map_view.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/sensor_choice.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// What tracking, local mapping and loop closing of one run share. The graph belongs to the jobs of the
/// KeyframePipeline while any are under way; all else is the tracking thread's.
struct OrbSession {
  /// Error for options out of range, and where the source lacks what `sensor` names.
  OrbSession(const OrbSlamOptions& settings, const SourceInfo& source, const SlamContext& context);

  OrbSlamOptions options;
  SensorChoice sensor;
  MapGraph graph;
  FrameTrajectory trajectory;
  std::optional<MapScale> scale;  ///< Of a map given.
  MapArchive* archive = nullptr;
  const std::atomic<bool>* stop = nullptr;
  bool mapping = true;    ///< False: localization in a map given.
  bool has_map = false;   ///< Initialized.
  bool tracking = false;  ///< The last frame's pose is known.
  int lost_frames = 0;    ///< Since it no longer is.
  std::int64_t next_keyframe = 0;
  std::int64_t frame_number = 0;  ///< Frames given, of any kind.
  TimeNs last_stamp = 0;          ///< Of the last frame with features.

  bool mono() const { return sensor.sensor == CameraKind::mono; }
  bool stopped() const { return stop != nullptr && stop->load(); }
  MapViewOptions view_options() const { return {options.local_keyframes, options.local_landmarks}; }
  FrameTime frame_time(TimeNs stamp) const { return {frame_number, stamp}; }
};

}  // namespace rastro
