// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "rastro/slam/orb/initialization/initializer.h"
#include "rastro/slam/orb/keyframe_pipeline.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"
#include "rastro/slam/orb/tracking/keyframe_insertion.h"

namespace rastro {

/// Map initialization from two views of one camera (Mur-Artal et al. 2015, section IV) or from one frame with depth
/// (Mur-Artal and Tardos 2017, section III.C). A map from two views is on trial: it is dropped if the following frames
/// contradict it.
class Initialization {
 public:
  /// All outlive this.
  Initialization(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline, KeyframeInsertion& keyframes);

  /// Tries to start the map, or a submap once tracking has been lost long enough, with this frame; otherwise the update
  /// says what is missing.
  void process(const std::shared_ptr<const FeatureFrame>& frame, SlamUpdate& update);
  /// A map from two views is verified by the frames after it.
  bool is_on_trial() const { return trial_frames_ > 0; }
  /// Whether a tracked frame is the last of several in a row that do not fit a map on trial.
  bool is_contradicted_by(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& tracked);
  /// Removes the map on trial, that is the tracked frame's submap. Initialization starts again with the frames kept.
  /// False: the submap was joined to another just now, and stays.
  bool drop_map(const TrackingResult& tracked, SlamUpdate& update);
  /// Ends a trial and clears the frames kept.
  void reset();

 private:
  void from_two_views(const std::shared_ptr<const FeatureFrame>& frame, SlamUpdate& update);
  void from_depth(const std::shared_ptr<const FeatureFrame>& frame, SlamUpdate& update);
  bool has_enough_near(const FeatureFrame& frame, int near, SlamUpdate& update) const;
  bool may_begin() const;
  void report_waiting(SlamUpdate& update) const;
  bool create_map(const InitialPair& pair, SlamUpdate& update);
  int next_submap() const;
  void begin_tracking(std::int64_t keyframe);
  void add_frame(const FeatureFrame& frame, const TrackingResult& tracked);
  void add_keyframe(const FeatureFrame& frame);
  void report(std::string event, SlamUpdate& update) const;
  void track_kept_frames(const InitialPair& pair);
  void track_backward(std::size_t first);
  void restart_at(std::int64_t keyframe);

  OrbSession& session_;
  FrameTracker& tracker_;
  KeyframePipeline& pipeline_;
  KeyframeInsertion& keyframes_;
  Initializer initializer_;
  int trial_frames_ = 0;  ///< Remaining frames of the trial of a map from two views.
  int trial_submap_ = 0;
  int contradictions_ = 0;  ///< Number of contradicting frames in a row.
};

}  // namespace rastro
