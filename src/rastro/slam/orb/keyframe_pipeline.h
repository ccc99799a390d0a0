// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "rastro/backend/pipeline.h"
#include "rastro/base/task_pool.h"
#include "rastro/slam/orb/local_mapping/local_mapping.h"
#include "rastro/slam/orb/local_mapping/map_thinning.h"
#include "rastro/slam/orb/loop_closing/global_bundle_adjustment.h"
#include "rastro/slam/orb/loop_closing/loop_closing.h"
#include "rastro/slam/orb/map/keyframe_database.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

/// Processes keyframes beside tracking: local mapping, loop closing, and after a loop bundle adjustment of the whole
/// submap. Results are handed over to tracking at a fixed later frame, as a view of the map.
class KeyframePipeline {
 public:
  /// Session and tracker outlive this; the tracker gets the views.
  KeyframePipeline(OrbSession& session, FrameTracker& tracker, const SlamContext& context);

  /// Maps a keyframe beside tracking. `stamp` is that of its frame.
  void insert(std::shared_ptr<const KeyframeInput> keyframe, TimeNs stamp);
  /// Maps a keyframe at once, without loop closing; only while no job is in flight.
  void insert_now(const KeyframeInput& keyframe);
  /// Whether a keyframe can be taken now. If not, as in a live run where mapping falls behind, it counts as dropped.
  bool accepts() { return mapping_.accepts(); }
  std::int64_t dropped_frames() const { return mapping_.statistics().dropped; }
  /// Only while no job is in flight.
  MapMemory map_memory() const { return thinning_.memory(session_.trajectory.bytes()); }
  /// Whether local mapping has no job in flight.
  bool idle() const { return mapping_.empty(); }
  /// Whether it is time for another keyframe: idle, and in a live run no sooner than offline. Keyframes of every frame,
  /// as a fast machine could map them, have less parallax and give a worse map.
  bool settled(TimeNs stamp) const { return mapping_.settled(session_.frame_time(stamp)); }

  /// Takes the results that are to be handed over at this frame.
  void take_results(TimeNs stamp, std::vector<SlamEvent>& events);
  /// Waits for local mapping and loop closing and takes all results: the caller may use the graph until the next
  /// insert().
  void take_all_results(std::vector<SlamEvent>& events);
  /// Waits for local mapping, takes its results and cancels a bundle adjustment in flight: no job touches the graph
  /// until the next insert().
  void pause(std::vector<SlamEvent>& events);
  /// Waits until the graph may be read; the results are not taken yet.
  void wait() const { mapping_.wait(); }
  /// After the last frame: takes all results, adjusts the whole map if it is small enough and the run is not stopped,
  /// and refines the trajectory with it.
  void finish(std::vector<SlamEvent>& events);
  /// Saves the map to the archive if it is time to.
  void archive_map();

  /// These access the graph: only while no job is in flight.
  LocalMapping& local_mapping() { return local_mapping_; }
  KeyframeDatabase& database() { return database_; }

 private:
  struct Result {
    std::shared_ptr<const MapView> view;
    std::vector<SlamEvent> events;
    std::optional<LoopResult> loop;
    std::shared_ptr<GlobalBundleAdjustment> adjustment;  ///< Still to be run; null: none.
    MapBudget budget;
    std::vector<TrackedFrame> refined;  ///< Frames that no longer need their observations.
    std::int64_t keyframe = -1;
    std::shared_ptr<const DirectView> view_of_keyframe;  ///< Null: features alone.
    std::vector<AdjustedKeyframe> adjusted;
    std::vector<std::int64_t> removed;  ///< Keyframes.
  };

  Result process(const KeyframeInput& keyframe, std::size_t trajectory_bytes);
  void spend_sparingly(const MapBudget& budget);
  Result apply(const GlobalBundleAdjustment& adjustment, std::int64_t center);
  void take(Result result, std::vector<SlamEvent>& events);
  void note_loop(const LoopResult& loop);
  void begin_adjustment(std::shared_ptr<GlobalBundleAdjustment> adjustment);
  void take_adjustment(std::shared_ptr<GlobalBundleAdjustment> adjustment, TimeNs stamp);
  void cancel_adjustment();
  void adjust_map();
  HandOverDelay mapping_delay() const;

  OrbSession& session_;
  FrameTracker& tracker_;
  StepsShown on_finishing_;
  TaskPool adjusting_pool_;
  TaskPool mapping_pool_;  ///< Separate, so that tracking's loops never wait for mapping's.
  LocalMapping local_mapping_;
  MapThinning thinning_;
  KeyframeDatabase database_;
  LoopClosing loop_closing_;
  std::shared_ptr<GlobalBundleAdjustment> adjustment_;       ///< In flight; null: none.
  std::weak_ptr<GlobalBundleAdjustment> newest_adjustment_;  ///< Of mapping's jobs: that of the last loop.
  // Last members: their jobs use what is above.
  Pipeline<Result> mapping_;
  Pipeline<std::shared_ptr<GlobalBundleAdjustment>> adjusting_;
};

}  // namespace rastro
