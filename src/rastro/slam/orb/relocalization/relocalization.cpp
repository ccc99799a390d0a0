// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/relocalization/relocalization.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rastro/slam/orb/tracking/jump_check.h"
#include "rastro/slam/orb/tracking/tracked_frame.h"

namespace rastro {
Relocalization::Relocalization(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline,
                               KeyframeInsertion& keyframes)
    : session_(session),
      tracker_(tracker),
      pipeline_(pipeline),
      keyframes_(keyframes),
      relocalizer_(session.options, session.graph, pipeline.database()) {}

std::optional<TrackingResult> Relocalization::relocalize(const FramePointer& frame, std::vector<SlamEvent>& events) {
  pipeline_.take_all_results(events);
  keep(frame);
  const auto relocation = relocalizer_.find(*frame, session_.min_inliers(), hinted_keyframes());
  if (!relocation) return std::nullopt;
  tracker_.set_view(view_of(session_.graph, relocation->keyframe, session_.view_options()));
  tracker_.restart(relocation->camera_from_world, {}, frame);
  TrackingResult tracked = tracker_.track_from(frame, relocation->camera_from_world);
  if (!tracked.ok) return std::nullopt;
  session_.tracking = true;
  lost_.pop_back();
  hypothesis_ = {relocation->keyframe, tracker_, {}, {}};
  return tracked;
}

/// Relative to a keyframe, which moves with the corrections of the map. What is left of an earlier loss, which a new
/// submap ended, is not tracked from another place.
void Relocalization::on_lost() {
  lost_.clear();
  const std::int64_t keyframe = tracker_.view()->center;
  const SE3 world_from_keyframe = tracker_.view()->keyframe(keyframe).camera_from_world.inverse();
  last_pose_ = {keyframe, tracker_.last_pose() * world_from_keyframe, tracker_.velocity(), session_.frame_number};
}

/// Within a few frames and one submap, no farther than twice the last velocity leads, plus a little where that was
/// small.
bool Relocalization::continues_motion(const SE3& camera_from_world) const {
  constexpr std::int64_t most_frames = 5;
  constexpr double least_distance = 0.05, least_angle_rad = 0.05;  // meters, or the median depth of the first map
  const MapGraph& graph = session_.graph;
  if (!last_pose_ || !graph.has_keyframe(last_pose_->keyframe)) return false;
  if (graph.submap(last_pose_->keyframe) != graph.submap(hypothesis_->keyframe)) return false;
  const std::int64_t frames = session_.frame_number - last_pose_->frame + 1;
  if (frames > most_frames) return false;
  const SE3 last = last_pose_->camera_from_keyframe * graph.keyframe(last_pose_->keyframe).camera_from_world;
  const SE3 moved = camera_from_world * last.inverse();
  const double reach = 2.0 * static_cast<double>(frames);
  return moved.translation().norm() <= least_distance + reach * last_pose_->velocity.translation().norm() &&
         moved.rotation().log().norm() <= least_angle_rad + reach * last_pose_->velocity.rotation().log().norm();
}

/// Adds the frame to the evidence. The fewer frames, the less is asked of it: a wrong pose may be tracked for a while,
/// but a right one must not be rejected by one bad frame.
Rejection Relocalization::judge_with(const FeatureFrame& frame, const TrackingResult& tracked) {
  Evidence& evidence = hypothesis_->evidence;
  evidence.inliers += tracked.inliers;
  evidence.observed += tracked.inliers;
  evidence.matches += tracked.matches;
  evidence.predicted += static_cast<int>(tracked.visible.size());
  evidence.chance_observed += 1.0 + tracker_.chance_inliers(frame, tracked.camera_from_world);
  const OrbSlamOptions& options = session_.options;
  AcceptanceOptions asked{.min_inliers = session_.min_inliers(), .min_chance_ratio = options.min_chance_ratio};
  if (is_enough(tracked)) {
    asked.min_chance_ratio = options.relocalize_chance_ratio;
    if (!continues_motion(tracked.camera_from_world)) asked.min_observed_share = options.relocalize_visible_share;
  }
  return judge(evidence, asked);
}

/// Whether the frames that agree are enough, with this one.
bool Relocalization::is_enough(const TrackingResult& tracked) const {
  return static_cast<int>(hypothesis_->frames.size()) + 1 >= session_.options.relocalize_frames ||
         continues_motion(tracked.camera_from_world);
}

bool Relocalization::confirm(const FramePointer& frame, const TrackingResult& tracked, SlamUpdate& update) {
  pipeline_.wait();  // a bundle adjustment that ended meanwhile is written into the graph
  const Rejection rejection = judge_with(*frame, tracked);
  if (rejection == Rejection::none && is_enough(tracked)) {
    accept(tracked, update);
    return true;
  }
  const std::size_t agreeing = hypothesis_->frames.size() + 1;
  if (agreeing > 1) ++session_.lost_frames;
  hypothesis_->frames.emplace_back(
      frame, tracked_frame(session_.graph, *tracker_.view(), *frame, tracked, session_.options.pixel_sigma));
  const Evidence& evidence = hypothesis_->evidence;
  update.state = SlamState::lost;
  update.reason = rejection == Rejection::none ? SlamReason::unconfirmed : SlamReason::not_found;
  update.detail =
      fmt::format("in keyframe {}: {} of {} visible landmarks fit, {:.0f} would by chance; {} of {} frames agree",
                  hypothesis_->keyframe, evidence.inliers, evidence.predicted, evidence.chance_observed,
                  rejection == Rejection::none ? agreeing : 0, session_.options.relocalize_frames);
  if (rejection != Rejection::none) reject();
  return false;
}

void Relocalization::reject() {
  for (auto& [frame, tracked] : hypothesis_->frames) keep(frame);
  hypothesis_.reset();
  session_.tracking = false;
}

void Relocalization::accept(const TrackingResult& tracked, SlamUpdate& update) {
  track_lost_frames(std::move(hypothesis_->first));
  for (const auto& [frame, unconfirmed] : hypothesis_->frames) session_.trajectory.add(unconfirmed);
  session_.initial_pose.reset();
  keyframes_.on_relocalized(tracked.inliers);
  update.state = SlamState::relocalized;
  update.reason = SlamReason::none;
  update.detail.clear();
  const Evidence& evidence = hypothesis_->evidence;
  update.events.push_back(
      {"relocalized",
       fmt::format("in keyframe {} with {} landmarks after {} frames; {} of {} visible ones fit, {:.0f} "
                   "would by chance",
                   hypothesis_->keyframe, tracked.inliers, session_.lost_frames, evidence.inliers, evidence.predicted,
                   evidence.chance_observed),
       hypothesis_->keyframe});
  hypothesis_.reset();
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

void Relocalization::keep(const FramePointer& frame) {
  lost_.push_back(frame);
  if (lost_.size() > static_cast<std::size_t>(session_.options.init_frames)) lost_.pop_front();
}

/// Backward from the first relocalized frame, as far as tracking succeeds and, in a given map, the motion is plausible.
void Relocalization::track_lost_frames(FrameTracker backward) {
  JumpCheck jump_check(session_.mapping || session_.mono() ? 0.0 : session_.options.max_acceleration);
  while (!lost_.empty()) {
    const FeatureFrame& frame = *lost_.back();
    const SE3 predicted = backward.predicted();
    const TrackingResult tracked = backward.track(lost_.back());
    if (!tracked.ok) break;
    const TimeNs backward_time = -frame.data().stamp;
    if (jump_check.jumps(backward_time, predicted, tracked.camera_from_world, tracked.covariance)) break;
    session_.trajectory.add(
        tracked_frame(session_.graph, *backward.view(), frame, tracked, session_.options.pixel_sigma));
    lost_.pop_back();
  }
  lost_.clear();
}

}  // namespace rastro
