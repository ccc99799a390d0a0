// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/base/background.h"
#include "rastro/base/task_pool.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/slam/orb/frame_tracker.h"
#include "rastro/slam/orb/frame_way.h"
#include "rastro/slam/orb/initialiser.h"
#include "rastro/slam/orb/local_mapper.h"
#include "rastro/slam/orb/loop_closer.h"
#include "rastro/slam/orb/map_export.h"
#include "rastro/slam/orb/map_graph.h"
#include "rastro/slam/orb/orb_slam.h"
#include "rastro/slam/orb/place_memory.h"
#include "rastro/slam/orb/relocaliser.h"
#include "rastro/slam/orb/sensor_choice.h"
#include "rastro/slam/orb/submap_adjustment.h"
#include "rastro/slam/orb/track_association.h"

namespace rastro {

/// The method at work; orb_slam*.cpp each hold a part of it.
class OrbSlam::State {
 public:
  State(const OrbSlamOptions& options, const SourceInfo& source, const SlamContext& context);

  SlamUpdate process(const Frame& frame);
  std::vector<SlamEvent> finish();
  Trajectory trajectory() const;
  std::shared_ptr<const Map> snapshot() const;

 private:
  using FramePointer = std::shared_ptr<const FeatureFrame>;

  struct MappingResult {
    std::shared_ptr<const MapView> view;
    std::vector<SlamEvent> events;
    std::shared_ptr<SubmapAdjustment> adjustment;  ///< To be done; null: none.
  };
  struct Pending {
    std::int64_t due = 0;  ///< Number of the first frame that may see it, and ...
    TimeNs due_stamp = 0;  ///< ... its least stamp.
    std::size_t job = 0;
    std::shared_ptr<MappingResult> result;
  };

  /// Under way; the tracking thread alone knows of it.
  struct Adjustment {
    std::int64_t due = 0;  ///< As above.
    TimeNs due_stamp = 0;
    std::size_t job = 0;
    std::shared_ptr<SubmapAdjustment> work;
  };

  void use_map(const SlamContext& context);
  void keep_map();
  bool relocalise(const FramePointer& frame, SlamUpdate& update);
  void place_lost();
  void say_submap(const TrackResult& tracked, SlamUpdate& update) const;
  void follow_reference(const TrackResult& tracked);
  void check_and_look(const Frame& frame, SlamUpdate& update);
  void look(const Frame& frame, SlamUpdate& update);
  SE3 depth_from_colour(const Frame& frame) const;
  void follow(const FramePointer& frame, const std::vector<FollowedLandmark>& followed, SlamUpdate& update);
  void on_pose(const FramePointer& frame, const TrackResult& tracked, SlamUpdate& update);
  void on_loss(const FramePointer& frame, SlamUpdate& update);
  bool begin(const FramePointer& frame, SlamUpdate& update);
  bool begin_from_pair(const StartPair& start, SlamUpdate& update);
  bool begin_from_depth(const FramePointer& frame, SlamUpdate& update);
  int next_submap() const;
  bool proves_wrong(const FramePointer& frame, const TrackResult& tracked);
  void drop_start(const TrackResult& tracked, SlamUpdate& update);
  void track_waiting(const StartPair& start);
  void track_back(std::size_t first);
  void place(const FeatureFrame& frame, const TrackResult& tracked);
  void place_keyframe(const FeatureFrame& frame, std::int64_t keyframe);
  void count_seen(const TrackResult& tracked);
  bool needs_keyframe(const FeatureFrame& frame, const TrackResult& tracked) const;
  KeyframeInput keyframe_input(const FramePointer& frame, const TrackResult& tracked);
  void make_keyframe(const FramePointer& frame, const TrackResult& tracked, SlamUpdate& update);
  void map_now(const FramePointer& frame, const TrackResult& tracked);
  void take_results(TimeNs stamp, std::vector<SlamEvent>& events);
  void take_all_results(std::vector<SlamEvent>& events);
  void take_next_result(std::vector<SlamEvent>& events);
  bool is_due(std::int64_t due, TimeNs due_stamp, int frames_at_most, TimeNs stamp) const;
  void begin_adjustment(const std::shared_ptr<SubmapAdjustment>& work);
  void take_adjustment(TimeNs stamp);
  void drop_adjustment();
  void wait_for_mapping() const { background_.wait_for_all(); }
  MapViewOptions view_options() const { return {options_.local_keyframes, options_.local_landmarks}; }
  std::vector<std::uint32_t> fresh_features(const FeatureFrame& frame, const TrackResult& tracked) const;

  OrbSlamOptions options_;
  SensorChoice sensor_;
  FrameCheck check_;
  std::optional<FrameRectifier> rectifier_;
  FeatureMaker maker_;
  MapGraph graph_;
  TaskPool adjusting_pool_;
  TaskPool mapping_pool_;  ///< Of its own, so that tracking's loops never wait for mapping's.
  LocalMapper mapper_;
  PlaceMemory places_;
  LoopCloser closer_;
  Relocaliser relocaliser_;
  FrameTracker tracker_;
  std::optional<TrackAssociation> tracks_;  ///< Where frontend is tracks.
  Initialiser initialiser_;
  FrameWay way_;
  std::deque<Pending> pending_;
  std::vector<std::int64_t> visible_, found_;
  std::int64_t next_keyframe_ = 0;
  std::int64_t seen_ = 0;           ///< Frames given, of any kind.
  TimeNs last_stamp_ = 0;           ///< Of the last frame with features.
  std::int64_t keyframe_seen_ = 0;  ///< When the last keyframe was made.
  std::int64_t settled_seen_ = 0;   ///< When the way was last lost and found.
  bool tracking_ = false;
  bool exists_ = false;  ///< There is a map.
  bool maps_ = true;     ///< False: only finds its way in a map given.
  int lost_frames_ = 0;
  int trial_frames_ = 0;           ///< That a map just begun from one camera still has to prove itself in.
  int misfits_ = 0;                ///< Of them, in a row.
  std::deque<FramePointer> lost_;  ///< The last ones, to be placed once the way is known again.
  std::optional<MapScale> scale_;  ///< Of a map given.
  MapArchive* archive_;
  const std::atomic<bool>* stop_;
  SE3 last_pose_;  ///< world_from_camera
  std::optional<Adjustment> adjustment_;
  mutable Background background_;  ///< Last: its jobs use what is above.
  Background adjusting_;           ///< Whole submaps, beside mapping.
};

}  // namespace rastro
