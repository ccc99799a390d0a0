// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "rastro/backend/pipeline.h"
#include "rastro/base/task_pool.h"
#include "rastro/slam/orb/local_mapping/local_mapping.h"
#include "rastro/slam/orb/loop_closing/global_bundle_adjustment.h"
#include "rastro/slam/orb/loop_closing/loop_closing.h"
#include "rastro/slam/orb/map/keyframe_database.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/orb/tracking/frame_tracker.h"

namespace rastro {

/// What happens to keyframes beside tracking: local mapping, loop closing, and after a loop bundle adjustment of all.
/// What becomes of a keyframe is handed over to tracking at a fixed later frame, as a view of the map.
class KeyframePipeline {
 public:
  /// Session and tracker outlive this; the tracker gets the views.
  KeyframePipeline(OrbSession& session, FrameTracker& tracker, const SlamContext& context);

  /// Maps a keyframe beside tracking. `stamp`: of its frame.
  void insert(std::shared_ptr<const KeyframeInput> keyframe, TimeNs stamp);
  /// The same at once, without closing loops; only while nothing is under way.
  void insert_now(const KeyframeInput& keyframe);
  /// Has local mapping nothing under way?
  bool idle() const { return mapping_.empty(); }

  /// Takes what is due at a frame.
  void take_results(TimeNs stamp, std::vector<SlamEvent>& events);
  /// Takes all of local mapping and loop closing: the graph is the caller's afterwards, until the next insert().
  void take_all_results(std::vector<SlamEvent>& events);
  /// Takes all of local mapping and gives up an adjustment under way: nothing touches the graph until the next
  /// insert().
  void pause(std::vector<SlamEvent>& events);
  /// Until the graph may be read; results stay to be taken.
  void wait() const { mapping_.wait(); }
  /// After the last frame: takes whatever is under way, adjusts the map as a whole where it is small enough and the run
  /// is not stopped, and refines the trajectory by it.
  void finish(std::vector<SlamEvent>& events);
  /// Keeps the map safe where it is time to.
  void archive_map();

  /// These touch the graph: only while nothing is under way.
  LocalMapping& local_mapping() { return local_mapping_; }
  KeyframeDatabase& database() { return database_; }

 private:
  struct Result {
    std::shared_ptr<const MapView> view;
    std::vector<SlamEvent> events;
    std::shared_ptr<GlobalBundleAdjustment> adjustment;  ///< To be done; null: none.
  };

  Result process(const KeyframeInput& keyframe);
  Result apply(const GlobalBundleAdjustment& adjustment, std::int64_t center);
  void take(Result result, std::vector<SlamEvent>& events);
  void begin_adjustment(std::shared_ptr<GlobalBundleAdjustment> adjustment);
  void take_adjustment(std::shared_ptr<GlobalBundleAdjustment> adjustment, TimeNs stamp);
  void cancel_adjustment();
  void adjust_map();
  HandOverDelay mapping_delay() const;

  OrbSession& session_;
  FrameTracker& tracker_;
  TaskPool adjusting_pool_;
  TaskPool mapping_pool_;  ///< Of its own, so that tracking's loops never wait for mapping's.
  LocalMapping local_mapping_;
  KeyframeDatabase database_;
  LoopClosing loop_closing_;
  std::shared_ptr<GlobalBundleAdjustment> adjustment_;  ///< Under way; null: none.
  // Last: their jobs use what is above.
  Pipeline<Result> mapping_;
  Pipeline<std::shared_ptr<GlobalBundleAdjustment>> adjusting_;
};

}  // namespace rastro
