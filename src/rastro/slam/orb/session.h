// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "rastro/backend/map_uncertainty.h"
#include "rastro/backend/pipeline.h"
#include "rastro/slam/orb/direct_alignment.h"
#include "rastro/slam/orb/map/frame_trajectory.h"
#include "rastro/slam/orb/map/map_export.h"
#include "rastro/slam/orb/map/map_graph.h"
#include "rastro/slam/orb/map/map_view.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/sensor_choice.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// What a method of its own brings to these.
struct OrbMethodParts {
  std::string method = "orb";  ///< Its name, in maps.
  /// Null: features alone. Not for one camera.
  std::function<std::shared_ptr<const DirectAlignment>(const SensorChoice&)> direct = {};
};

/// What frames are aligned with, and by what.
struct DirectTracking {
  std::shared_ptr<const DirectAlignment> alignment = nullptr;  ///< Null: features alone.
  DirectKeyframes keyframes = DirectKeyframes(20);
};

/// The state that tracking, local mapping and loop closing of one run share. The graph belongs to the jobs of the
/// KeyframePipeline while any is in flight; all else belongs to the tracking thread.
struct OrbSession {
  /// Error for options out of range, and where the source lacks the sensor named in `sensor`.
  OrbSession(const OrbSlamOptions& settings, const SourceInfo& source, const SlamContext& context,
             const OrbMethodParts& parts = {});

  OrbSlamOptions options;
  SensorChoice sensor;
  std::string method;  ///< In maps.
  DirectTracking direct;
  MapGraph graph;
  FrameTrajectory trajectory;
  MapUncertainty uncertainty;  ///< Of the keyframes.
  std::optional<GivenMap> given;
  MapArchive* archive = nullptr;
  const std::atomic<bool>* stop = nullptr;
  /// world_from_body. Where relocalization in a given map starts, until the first frame is localized.
  std::optional<SE3> initial_pose;
  double spacing = 1.0;         ///< Factor on the maximum interval between keyframes.
  double keyframe_share = 1.0;  ///< Factor on the share of landmarks below which a keyframe is made.
  bool mapping = true;          ///< False: localization in an existing map.
  bool has_map = false;         ///< Initialized.
  bool tracking = false;        ///< The last frame's pose is known.
  int lost_frames = 0;          ///< Number of frames since tracking was lost.
  std::int64_t next_keyframe = 0;
  std::int64_t frame_number = 0;  ///< Number of frames given, of any kind.
  TimeNs last_stamp = 0;          ///< Of the last frame with features.

  bool mono() const { return sensor.sensor == CameraKind::mono; }
  bool stopped() const { return stop != nullptr && stop->load(); }
  /// The errors of a map that nothing corrects any more are those of the poses in it.
  MapViewOptions view_options() const { return {options.local_keyframes, options.local_landmarks, !mapping}; }
  /// Inliers that a pose needs: of the map that is being made, or of one that cannot be harmed.
  int min_inliers() const { return mapping ? options.min_inliers : options.localization_inliers; }
  FrameTime frame_time(TimeNs stamp) const { return {frame_number, stamp}; }
};

}  // namespace rastro
