// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/slam/orb/keyframe_pipeline.h"
#include "rastro/slam/orb/relocalization/frame_relocalizer.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"
#include "rastro/slam/orb/tracking/keyframe_insertion.h"

namespace rastro {

/// Relocalizes when tracking is lost (Mur-Artal et al. 2015, section V.C), and then estimates the poses of the frames
/// lost before.
class Relocalization {
 public:
  /// All outlive this.
  Relocalization(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline, KeyframeInsertion& keyframes);

  /// nullopt: not relocalized; the frame is kept.
  std::optional<TrackingResult> relocalize(const std::shared_ptr<const FeatureFrame>& frame, SlamUpdate& update);

 private:
  std::vector<std::int64_t> hinted_keyframes() const;
  void keep(const std::shared_ptr<const FeatureFrame>& frame);
  void track_lost_frames();

  OrbSession& session_;
  FrameTracker& tracker_;
  KeyframePipeline& pipeline_;
  KeyframeInsertion& keyframes_;
  FrameRelocalizer relocalizer_;
  std::deque<std::shared_ptr<const FeatureFrame>> lost_;  ///< The most recent ones.
};

}  // namespace rastro
