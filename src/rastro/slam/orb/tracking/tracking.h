// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/odometry/frame_check.h"
#include "rastro/slam/orb/initialization/initialization.h"
#include "rastro/slam/orb/keyframe_pipeline.h"
#include "rastro/slam/orb/relocalization/relocalization.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/feature_count.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"
#include "rastro/slam/orb/tracking/jump_check.h"
#include "rastro/slam/orb/tracking/keyframe_insertion.h"
#include "rastro/slam/orb/tracking/track_association.h"

namespace rastro {

/// Estimates the pose of every frame and decides which become keyframes, METHODS 6 (Mur-Artal et al. 2015, section V).
class Tracking {
 public:
  /// Session, tracker and pipeline outlive this. `pool`: null: one thread.
  Tracking(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline, TaskPool* pool);

  /// Tracks one frame. `update` has its number and stamp and the last pose, of the camera in use; everything else is
  /// filled in.
  void process(const Frame& frame, SlamUpdate& update);
  /// Of the last frame whose features were extracted.
  const std::vector<FeatureObservation>& observations() const { return observations_; }

 private:
  using FramePointer = std::shared_ptr<const FeatureFrame>;
  /// The measurements of a frame.
  struct Measurements {
    FramePointer features;
    std::vector<LandmarkTrack> tracks;         ///< Only with frontend `tracks`.
    std::shared_ptr<const DirectView> view{};  ///< Null: features alone.
  };

  bool is_usable(const Frame& frame, SlamUpdate& update);
  Measurements extract_features(const Frame& frame, SlamUpdate& update);
  std::optional<TrackingResult> track_map(const Measurements& measured, SlamUpdate& update);
  void align(const Measurements& measured, TrackingResult& tracked, SlamUpdate& update);
  std::optional<TrackingResult> relocalize(const FramePointer& frame, SlamUpdate& update);
  /// Whether tracking has a pose that is believed.
  bool follows_map() const;
  bool confirm(const FramePointer& frame, const TrackingResult& tracked, SlamUpdate& update);
  void initialize(const Measurements& measured, SlamUpdate& update);
  void observe(const TrackingResult& tracked, ObservationState fitting, ObservationState contradicted);
  void observe_first_landmarks(const FeatureFrame& frame);
  void report_pose(const FeatureFrame& frame, const TrackingResult& tracked, SlamUpdate& update);
  void note_uncertainty(std::int64_t keyframe, const TrackingResult& tracked, const Eigen::Vector3d& position);
  double scale_variance(const Matrix6d& covariance, const Eigen::Vector3d& position);
  void insert_keyframe(const Measurements& measured, const TrackingResult& tracked, SlamUpdate& update);
  SE3 depth_from_color(const Frame& frame) const;
  bool waits_for_rotation(const FramePointer& frame, SlamUpdate& update);
  std::string why_lost(const TrackingResult& tracked) const;
  void on_lost(const TrackingResult& tracked, SlamUpdate& update);
  bool jumps_in_given_map(const TrackingResult& tracked, const SE3& predicted, SlamUpdate& update);
  void report_contradiction(const TrackingResult& tracked, SlamUpdate& update) const;
  bool is_dropped_start(const Measurements& measured, TrackingResult& tracked, SlamUpdate& update);
  void report_submap(int submap, SlamUpdate& update) const;
  void follow_reference(const TrackingResult& tracked);

  OrbSession& session_;
  FrameTracker& tracker_;
  KeyframePipeline& pipeline_;
  FrameCheck check_;
  std::optional<FrameRectifier> rectifier_;
  FeatureMaker extractor_;
  FeatureCount feature_count_;
  std::optional<TrackAssociation> tracks_;
  KeyframeInsertion keyframes_;
  Initialization initialization_;
  Relocalization relocalization_;
  FramePointer first_;                            ///< Waits for the next frame, to know its rotation.
  std::vector<FeatureObservation> observations_;  ///< Of the last frame whose features were extracted.
  JumpCheck jump_check_;
  double map_extent_ = 0.0;  ///< Largest distance of a keyframe from the world's origin.
};

}  // namespace rastro
