// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/sensor/frame.h"
#include "rastro/slam/orb/map/feature_frame.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"
#include "rastro/track/tracker.h"

namespace rastro {

/// From frame to frame by feature tracks that survive occlusion (METHODS 1), in place of a search around where constant
/// velocity expects things: what a track showed once it shows again, after a jerk of the camera or behind a passer-by.
/// Galardi, Castro, Pire name it as what their tracks are to be used for.
class TrackAssociation {
 public:
  TrackAssociation(const OrbSlamOptions& options, const Camera& camera, TaskPool* pool);

  /// Landmarks whose tracks go on or come back in this picture, and where. Ids of the landmarks ascend.
  std::vector<LandmarkTrack> follow(const Frame& frame);
  /// What the tracks of the picture followed last show: the landmark of the nearest feature.
  void learn(const FeatureFrame& frame, const std::vector<TrackedPoint>& points);

 private:
  OrbSlamOptions options_;
  Camera camera_;
  Tracker tracker_;
  TrackFrame last_;
  int width_ = 0, height_ = 0;
  std::map<std::int64_t, std::int64_t> landmark_of_track_;
};

}  // namespace rastro
