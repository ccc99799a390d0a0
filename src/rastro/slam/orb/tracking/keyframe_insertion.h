// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "rastro/slam/orb/keyframe_pipeline.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

/// Decides which tracked frames become keyframes, and prepares them (Mur-Artal et al. 2015, section V.E; Mur-Artal and
/// Tardos 2017, section III.D).
class KeyframeInsertion {
 public:
  /// All outlive this.
  KeyframeInsertion(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline)
      : session_(session), tracker_(tracker), pipeline_(pipeline) {}

  bool needs_keyframe(const FeatureFrame& frame, const TrackingResult& tracked) const;
  /// Features with depth, not too far, that fit no landmark: a keyframe makes landmarks of them. None with one camera.
  std::vector<std::uint32_t> new_depth_features(const FeatureFrame& frame, const TrackingResult& tracked) const;
  /// Hands the keyframe to the pipeline. Returns the features with depth that become landmarks at once. Does nothing in
  /// a live run where mapping has fallen behind. `view`: null: features alone.
  std::vector<std::uint32_t> insert(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& tracked,
                                    SlamUpdate& update, std::shared_ptr<const DirectView> view = nullptr);
  /// Maps the keyframe at once, for frames before a map's first keyframe.
  void insert_now(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& tracked);

  /// Counts landmarks that should be visible in a frame and those found in it, for culling.
  void count_observations(const TrackingResult& tracked);
  void forget_observations();
  /// A map was initialized: its keyframes count as made now.
  void on_initialized();
  /// After relocalization: no keyframe until tracking has settled. `inliers`: landmarks that fit the pose.
  void on_relocalized(int inliers);

 private:
  bool is_settled(const TrackingResult& tracked) const;
  KeyframeInput input_of(const FeatureFrame& frame, const TrackingResult& tracked);

  OrbSession& session_;
  FrameTracker& tracker_;
  KeyframePipeline& pipeline_;
  std::map<std::int64_t, LandmarkCounts> counts_;  ///< Since the last keyframe.
  std::int64_t keyframe_frame_ = 0;                ///< Frame number of the last keyframe.
  std::int64_t relocalized_frame_ = 0;             ///< Frame number of the last relocalization; 0: none in this map.
  int relocalized_inliers_ = 0;                    ///< Landmarks that fit its pose then.
};

}  // namespace rastro
