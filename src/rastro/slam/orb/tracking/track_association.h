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

/// Data association by feature tracks that survive occlusion (METHODS 1), instead of a search around the
/// constant-velocity prediction: a track that reappears is the same landmark again, also after a jerk of the camera or
/// behind a passer-by. Galardi, Castro and Pire name this as a use of their tracks.
class TrackAssociation {
 public:
  TrackAssociation(const OrbSlamOptions& options, const Camera& camera, TaskPool* pool);

  /// Landmarks whose tracks continue or reappear in this image, with their positions. Ids of the landmarks ascend.
  std::vector<LandmarkTrack> follow(const Frame& frame);
  /// Assigns the tracks of the last image to the landmark of the nearest feature.
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
