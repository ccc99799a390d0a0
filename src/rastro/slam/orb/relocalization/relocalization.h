// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/backend/acceptance.h"
#include "rastro/slam/orb/keyframe_pipeline.h"
#include "rastro/slam/orb/relocalization/frame_relocalizer.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"
#include "rastro/slam/orb/tracking/keyframe_insertion.h"

namespace rastro {

/// Relocalizes when tracking is lost (Mur-Artal et al. 2015, section V.C). A relocalization is a hypothesis at first:
/// several frames in a row must be tracked from it, with several times the inliers that a wrong pose would have by
/// chance. One frame is enough where tracking was lost a moment ago and the camera is about where its motion was
/// leading. Then these frames and those lost before get poses.
class Relocalization {
 public:
  /// All outlive this.
  Relocalization(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline, KeyframeInsertion& keyframes);

  /// Tracking has been lost in this frame.
  void on_lost();
  /// Begins a hypothesis, which the tracker then follows. nullopt: not relocalized; the frame is kept.
  std::optional<TrackingResult> relocalize(const std::shared_ptr<const FeatureFrame>& frame,
                                           std::vector<SlamEvent>& events);
  /// Whether tracking follows a hypothesis.
  bool is_unconfirmed() const { return hypothesis_.has_value(); }
  /// Judges the hypothesis by a frame tracked from it. Returns whether it is confirmed now; otherwise the frame is lost
  /// as `update` says.
  bool confirm(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& tracked, SlamUpdate& update);
  /// Drops the hypothesis: a frame could not be tracked from it.
  void reject();

 private:
  using FramePointer = std::shared_ptr<const FeatureFrame>;
  /// A relocalization that is not believed yet.
  struct Unconfirmed {
    std::int64_t keyframe = 0;
    FrameTracker first;  ///< Tracking at its first frame, to track backward from.
    std::vector<std::pair<FramePointer, TrackedFrame>> frames;
    Evidence evidence;  ///< Of all its frames so far.
  };
  /// The last pose before the loss.
  struct LastPose {
    std::int64_t keyframe = 0;
    SE3 camera_from_keyframe, velocity;
    std::int64_t frame = 0;  ///< Frame number of the first lost frame.
  };

  Rejection judge_with(const FeatureFrame& frame, const TrackingResult& tracked);
  bool is_enough(const TrackingResult& tracked) const;
  bool continues_motion(const SE3& camera_from_world) const;
  std::vector<std::int64_t> hinted_keyframes() const;
  void keep(const FramePointer& frame);
  void accept(const TrackingResult& tracked, SlamUpdate& update);
  void track_lost_frames(FrameTracker backward);

  OrbSession& session_;
  FrameTracker& tracker_;
  KeyframePipeline& pipeline_;
  KeyframeInsertion& keyframes_;
  FrameRelocalizer relocalizer_;
  std::deque<FramePointer> lost_;  ///< The most recent ones.
  std::optional<Unconfirmed> hypothesis_;
  std::optional<LastPose> last_pose_;
};

}  // namespace rastro
