// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/backend/pipeline.h"
#include "rastro/base/task_pool.h"
#include "rastro/slam/lsd/lsd_mapping.h"
#include "rastro/slam/lsd/lsd_motion.h"
#include "rastro/slam/lsd/pose_uncertainty.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Maps frames beside tracking: depths, keyframes, constraints. Tracking gets the results a fixed number of frames
/// later, so that every run gives the same bytes.
class LsdPipeline {
 public:
  /// Options, sensor and frames outlive this.
  LsdPipeline(const LsdOptions& options, const LsdSensor& sensor, const LsdFrameMaker& frames,
              const SlamContext& context);

  /// The results that are to be handed over at this frame, with their events and times.
  void take_results(const FrameTime& now, LsdMotion& motion, SlamUpdate& update);
  /// Waits for all results: the map may be used and changed until the next map().
  LsdMapping& idle(LsdMotion& motion, SlamUpdate& update);
  /// After the map was changed from outside; `is_new`: a submap has begun.
  void on_change(bool is_new);
  /// A frame that was tracked on current().
  void map(std::shared_ptr<const LsdFrame> frame, const ImageAlignment& tracked, bool is_sure, const LsdMotion& motion,
           const SlamUpdate& update);
  /// A frame that adds nothing but its pose: the next job does that.
  void place(const PlacedFrame& frame) { waiting_.push_back(frame); }
  /// Waits; the results are not taken yet. The map may be read until the next map().
  const LsdMapping& settled();

  bool is_busy() const { return !pipeline_.empty(); }  ///< Whether there are results to be handed over.
  bool has_keyframe() const { return current_.has_value(); }
  const CurrentKeyframe& current() const { return current_->keyframe; }  ///< If there is one.
  /// world_from_camera of a frame relative to it.
  SE3 pose_of(const SE3& camera_from_keyframe) const;
  /// None in a submap apart from the first, whose place is unknown, nor on a keyframe that it had before it was joined.
  std::optional<Matrix6d> covariance_of(const ImageAlignment& tracked, const SE3& world_from_camera) const;
  /// Says what is not known yet: where a submap lies, or its scale.
  void doubt(SlamUpdate& update) const;
  const MapMemory& memory() const { return memory_; }
  std::int64_t dropped_frames() const { return pipeline_.statistics().dropped; }

 private:
  struct Result {
    MappedKeyframe current;
    std::optional<Sim3> before_from_new;  ///< If it changed.
    AlignedFrame frame;                   ///< That became it.
    std::optional<SubmapJoint> joint;
    MapMemory memory;
    std::vector<SlamEvent> events;
    std::vector<StageTime> times;
    std::shared_ptr<const Map> map_to_keep;  ///< Null: none is to be kept safe.
  };
  void take(Result result, LsdMotion& motion, SlamUpdate& update);
  void add_uncertainty(const Result& result);
  void note_joint();
  void place_waiting();
  bool knows_scale(const ImageAlignment& tracked) const;
  AlignedFrame aligned(const ImageAlignment& tracked, const SE3& world_from_camera) const;

  const LsdOptions& options_;
  bool is_metric_;
  MapArchive* archive_;  ///< May be null.
  TaskPool mapping_pool_;
  LsdMapping mapping_;  ///< Belongs to the jobs while some are in flight.
  std::optional<MappedKeyframe> current_;
  PoseUncertainty uncertainty_;
  MapMemory memory_;
  int frames_on_current_ = 0;
  bool is_changing_ = false;          ///< The job of a keyframe is in flight.
  std::vector<PlacedFrame> waiting_;  ///< Without a job, or of a live run, whose jobs were dropped.
  FrameTime now_;
  Pipeline<Result> pipeline_;  ///< The last member: its jobs use what is above.
};

}  // namespace rastro
