// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/relocalization/relocalization.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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
  const auto relocation = relocalizer_.find(*frame, hinted_keyframes());
  if (!relocation) return std::nullopt;
  tracker_.set_view(view_of(session_.graph, relocation->keyframe, session_.view_options()));
  tracker_.restart(relocation->camera_from_world, {}, frame);
  TrackingResult tracked = tracker_.track_from(frame, relocation->camera_from_world);
  if (!tracked.ok) return std::nullopt;
  session_.tracking = true;
  session_.initial_pose.reset();
  lost_.pop_back();
  track_lost_frames();
  keyframes_.on_relocalized();
  update.state = SlamState::relocalized;
  update.reason = SlamReason::none;
  update.detail.clear();
  update.events.push_back({"relocalized", fmt::format("in keyframe {} with {} landmarks after {} frames",
                                                      relocation->keyframe, tracked.inliers, session_.lost_frames)});
  return tracked;
}

/// Keyframes of the first submap closest to the initial pose, with about the same viewing direction.
std::vector<std::int64_t> Relocalization::hinted_keyframes() const {
  if (!session_.initial_pose) return {};
  constexpr double least_cosine = 0.5;
  const SE3 world_from_camera = *session_.initial_pose * session_.sensor.camera_from_left().inverse();
  std::vector<std::pair<double, std::int64_t>> near;
  for (const std::int64_t id : session_.graph.keyframe_ids(0)) {
    const SE3 difference = session_.graph.keyframe(id).camera_from_world * world_from_camera;
    if ((difference.rotation() * Eigen::Vector3d::UnitZ()).z() >= least_cosine)
      near.emplace_back(difference.translation().norm(), id);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::int64_t> ids;
  for (const auto& [distance, id] : near) ids.push_back(id);
  ids.resize(std::min(ids.size(), static_cast<std::size_t>(session_.options.place_candidates)));
  return ids;
}

void Relocalization::keep(const std::shared_ptr<const FeatureFrame>& frame) {
  lost_.push_back(frame);
  if (lost_.size() > static_cast<std::size_t>(session_.options.init_frames)) lost_.pop_front();
}

/// Backward from the relocalized frame, as far as tracking succeeds.
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
