// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/slam/orb/keyframe_pipeline.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

/// Which tracked frames become keyframes, and what they bring (Mur-Artal et al. 2015, section V.E; Mur-Artal and Tardos
/// 2017, section III.D).
class KeyframeInsertion {
 public:
  /// All outlive this.
  KeyframeInsertion(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline)
      : session_(session), tracker_(tracker), pipeline_(pipeline) {}

  bool needs_keyframe(const FeatureFrame& frame, const TrackingResult& tracked) const;
  /// Mapped beside tracking.
  void insert(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& tracked, SlamUpdate& update);
  /// Mapped at once, for frames before a map's first keyframe.
  void insert_now(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& tracked);

  /// Landmarks that should be visible in a frame and that were found in it, for culling.
  void count_observations(const TrackingResult& tracked);
  void forget_observations();
  /// A map was initialized: its keyframes count as made now.
  void on_initialized();
  /// The pose was lost and found: no keyframe until it has settled.
  void on_relocalized() { relocalized_frame_ = session_.frame_number; }

 private:
  KeyframeInput input_of(const FeatureFrame& frame, const TrackingResult& tracked);
  std::vector<std::uint32_t> new_depth_features(const FeatureFrame& frame, const TrackingResult& tracked) const;

  OrbSession& session_;
  FrameTracker& tracker_;
  KeyframePipeline& pipeline_;
  std::vector<std::int64_t> visible_, found_;  ///< Since the last keyframe, one a frame.
  std::int64_t keyframe_frame_ = 0;            ///< Number of the frame of the last keyframe.
  std::int64_t relocalized_frame_ = 0;         ///< Of the last relocalization; 0: none in this map.
};

}  // namespace rastro
