// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "rastro/slam/orb/orb_slam_state.h"

namespace rastro {
namespace {

std::vector<TrackedPoint> points_of(const MapGraph& graph, std::int64_t keyframe) {
  std::vector<TrackedPoint> points;
  const MapKeyframe& seer = graph.keyframe(keyframe);
  for (std::uint32_t i = 0; i < seer.landmarks.size(); ++i) {
    if (seer.landmarks[i] < 0) continue;
    TrackedPoint point;
    point.feature = i;
    point.landmark = seer.landmarks[i];
    point.position = graph.landmark(point.landmark).position;
    points.push_back(point);
  }
  return points;
}

}  // namespace

/// Two views may agree on a wrong motion, as near a plane; those that follow do not.
bool OrbSlam::State::proves_wrong(const FramePointer& frame, const TrackResult& tracked) {
  constexpr int least_misfits = 3;
  if (trial_frames_ == 0) return false;
  misfits_ = tracked.mean_squared > options_.init_max_error ? misfits_ + 1 : 0;
  if (misfits_ == least_misfits) return true;
  initialiser_.keep(frame);
  if (--trial_frames_ == 0) initialiser_.clear();
  return false;
}

void OrbSlam::State::drop_start(const TrackResult& tracked, SlamUpdate& update) {
  take_all_results(update.events);
  const int submap = graph_.submap(tracked.reference);
  way_.forget(graph_, submap);
  const std::vector<std::int64_t> keyframes = graph_.keyframe_ids(submap);
  for (const std::int64_t id : keyframes) {
    if (graph_.keyframe(id).parent >= 0) graph_.remove_keyframe(id);
  }
  for (const std::int64_t id : graph_.keyframe_ids(submap)) graph_.remove_root(id);
  tracking_ = false;
  exists_ = graph_.keyframe_count() > 0;
  lost_frames_ = exists_ ? options_.lost_frames : 0;
  trial_frames_ = misfits_ = 0;
  visible_.clear();
  found_.clear();
  update.events.push_back({"start_dropped", fmt::format("submap {} does not fit what came after: squared error {:.1f}, "
                                                        "need {:.1f}; it begins anew",
                                                        submap, tracked.mean_squared, options_.init_max_error)});
}

/// A number that a dropped start has left free is taken again.
int OrbSlam::State::next_submap() const {
  if (!exists_) return 0;
  const int newest = graph_.submap_count() - 1;
  return graph_.keyframe_ids(newest).empty() ? newest : newest + 1;
}

bool OrbSlam::State::begin(const FramePointer& frame, SlamUpdate& update) {
  if (sensor_.sensor != CameraKind::mono) return begin_from_depth(frame, update);
  const auto start = initialiser_.add(frame);
  if (!exists_) update.reason = initialiser_.frames().size() < 2 ? SlamReason::first_frame : SlamReason::too_few_points;
  update.detail = initialiser_.detail();
  if (!start || (exists_ && lost_frames_ < options_.lost_frames)) return false;
  return begin_from_pair(*start, update);
}

bool OrbSlam::State::begin_from_pair(const StartPair& start, SlamUpdate& update) {
  take_all_results(update.events);
  const FramePointer first = initialiser_.frames()[start.first]->with_id(next_keyframe_);
  const FramePointer second = initialiser_.frames()[start.second]->with_id(next_keyframe_ + 1);
  next_keyframe_ += 2;
  const int submap = next_submap();
  if (!mapper_.start(first, second, start.second_from_first, start.pairs, start.points, submap)) {
    update.detail = fmt::format("fewer than {} points left after adjustment", options_.init_points);
    return false;
  }
  exists_ = tracking_ = true;
  keyframe_seen_ = seen_;
  settled_seen_ = 0;
  tracker_.set_view(view_of(graph_, second->data().id, view_options()));
  place_keyframe(*first, first->data().id);
  place_keyframe(*second, second->data().id);
  update.events.push_back({"submap", fmt::format("{} begun from frames {} and {} with {} points", submap,
                                                 first->data().frame, second->data().frame, graph_.landmark_count())});
  track_waiting(start);
  update.state = SlamState::tracking;
  update.reason = SlamReason::none;
  update.detail.clear();
  update.world_from_body = tracker_.last_pose().inverse();
  trial_frames_ = options_.init_trial_frames;
  misfits_ = 0;
  if (trial_frames_ == 0) initialiser_.clear();
  return true;
}

/// The frames between the two, those before them, and on from the second.
void OrbSlam::State::track_waiting(const StartPair& start) {
  const std::int64_t first = graph_.keyframe_ids().back() - 1, second = first + 1;
  const auto& frames = initialiser_.frames();
  tracker_.restart(graph_.keyframe(first).camera_from_world, points_of(graph_, first), graph_.keyframe(first).frame);
  track_back(start.first);
  tracker_.restart(graph_.camera_from_world(first), points_of(graph_, first), graph_.keyframe(first).frame);
  for (std::size_t i = start.first + 1; i < start.second; ++i) {
    const TrackResult tracked = tracker_.track(frames[i]);
    if (tracked.ok) place(*frames[i], tracked);
  }
  if (tracker_.track(frames[start.second]).ok) return;
  tracker_.restart(graph_.camera_from_world(second), points_of(graph_, second), graph_.keyframe(second).frame);
}

void OrbSlam::State::track_back(std::size_t first) {
  const auto& frames = initialiser_.frames();
  for (std::size_t i = first; i-- > 0;) {
    const TrackResult tracked = tracker_.track(frames[i]);
    if (!tracked.ok) break;
    place(*frames[i], tracked);
    if (needs_keyframe(*frames[i], tracked)) map_now(frames[i], tracked);
  }
}

bool OrbSlam::State::begin_from_depth(const FramePointer& frame, SlamUpdate& update) {
  if (exists_ && lost_frames_ < options_.lost_frames) return false;
  const auto known =
      std::count_if(frame->data().depths.begin(), frame->data().depths.end(), [](float depth) { return depth > 0.0F; });
  if (known < options_.start_depth_points) {
    update.reason = SlamReason::too_few_points;
    update.detail = fmt::format("{} features with depth, need {}", known, options_.start_depth_points);
    return false;
  }
  take_all_results(update.events);
  const FramePointer keyframe = frame->with_id(next_keyframe_++);
  const std::int64_t id = keyframe->data().id;
  const int submap = next_submap();
  mapper_.start(keyframe, submap);
  exists_ = tracking_ = true;
  keyframe_seen_ = seen_;
  settled_seen_ = 0;
  tracker_.set_view(view_of(graph_, id, view_options()));
  tracker_.restart(SE3(), points_of(graph_, id), keyframe);
  place_keyframe(*keyframe, id);
  update.state = SlamState::tracking;
  update.reason = SlamReason::none;
  update.world_from_body = SE3();
  update.events.push_back({"submap", fmt::format("{} begun with {} points", submap, known)});
  return true;
}

}  // namespace rastro
