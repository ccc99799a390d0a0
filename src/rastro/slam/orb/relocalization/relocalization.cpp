// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/relocalization/relocalization.h"

#include <fmt/format.h>

#include "rastro/slam/orb/tracking/tracked_frame.h"

namespace rastro {

Relocalization::Relocalization(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline,
                               KeyframeInsertion& keyframes)
    : session_(session),
      tracker_(tracker),
      pipeline_(pipeline),
      keyframes_(keyframes),
      relocalizer_(session.options, session.graph, pipeline.database()) {}

std::optional<TrackingResult> Relocalization::relocalize(const std::shared_ptr<const FeatureFrame>& frame,
                                                         SlamUpdate& update) {
  pipeline_.take_all_results(update.events);
  keep(frame);
  const auto relocation = relocalizer_.find(*frame);
  if (!relocation) return std::nullopt;
  tracker_.set_view(view_of(session_.graph, relocation->keyframe, session_.view_options()));
  tracker_.restart(relocation->camera_from_world, {}, frame);
  TrackingResult tracked = tracker_.track_from(frame, relocation->camera_from_world);
  if (!tracked.ok) return std::nullopt;
  session_.tracking = true;
  lost_.pop_back();
  track_lost_frames();
  keyframes_.on_relocalized();
  update.state = SlamState::relocalised;
  update.reason = SlamReason::none;
  update.detail.clear();
  update.events.push_back({"relocalised", fmt::format("in keyframe {} with {} landmarks after {} frames",
                                                      relocation->keyframe, tracked.inliers, session_.lost_frames)});
  return tracked;
}

void Relocalization::keep(const std::shared_ptr<const FeatureFrame>& frame) {
  lost_.push_back(frame);
  if (lost_.size() > static_cast<std::size_t>(session_.options.init_frames)) lost_.pop_front();
}

/// As far back from the one that was found as they can be tracked.
void Relocalization::track_lost_frames() {
  FrameTracker backward = tracker_;
  while (!lost_.empty()) {
    const FeatureFrame& frame = *lost_.back();
    const TrackingResult tracked = backward.track(lost_.back());
    if (!tracked.ok) break;
    session_.trajectory.add(
        tracked_frame(session_.graph, *tracker_.view(), frame, tracked, session_.options.pixel_sigma));
    lost_.pop_back();
  }
  lost_.clear();
}

}  // namespace rastro
