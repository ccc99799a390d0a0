// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "rastro/base/stopwatch.h"
#include "rastro/slam/orb/orb_slam_state.h"

namespace rastro {

void OrbSlam::State::on_loss(const FramePointer& frame, SlamUpdate& update) {
  Stopwatch stage;
  ++lost_frames_;
  update.state = exists_ ? SlamState::lost : SlamState::initialising;
  if (exists_ && update.reason == SlamReason::none) update.reason = SlamReason::not_found;
  const bool found = exists_ && relocalise(frame, update);
  if (exists_) update.times.push_back({"relocalise", stage.lap_ms()});
  if (found || !maps_) return;
  begin(frame, update);
  update.times.push_back({"start", stage.lap_ms()});
}

bool OrbSlam::State::relocalise(const FramePointer& frame, SlamUpdate& update) {
  take_all_results(update.events);
  lost_.push_back(frame);
  if (lost_.size() > static_cast<std::size_t>(options_.init_frames)) lost_.pop_front();
  if (!options_.loop_closing) places_.update();
  const auto relocation = relocaliser_.find(*frame);
  if (!relocation) return false;
  tracker_.set_view(view_of(graph_, relocation->keyframe, view_options()));
  tracker_.restart(relocation->camera_from_world, {}, frame);
  const TrackResult tracked = tracker_.track_from(frame, relocation->camera_from_world);
  if (!tracked.ok) return false;
  tracking_ = true;
  lost_.pop_back();
  place_lost();
  settled_seen_ = seen_;
  update.state = SlamState::relocalised;
  update.reason = SlamReason::none;
  update.detail.clear();
  update.events.push_back({"relocalised", fmt::format("in keyframe {} with {} landmarks after {} frames",
                                                      relocation->keyframe, tracked.inliers, lost_frames_)});
  on_pose(frame, tracked, update);
  initialiser_.clear();
  return true;
}

/// Frames before the one that was found again, as far back as they can be followed.
void OrbSlam::State::place_lost() {
  FrameTracker backwards = tracker_;
  while (!lost_.empty()) {
    const TrackResult tracked = backwards.track(lost_.back());
    if (!tracked.ok) break;
    place(*lost_.back(), tracked);
    lost_.pop_back();
  }
  lost_.clear();
}

}  // namespace rastro
