// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/initialization/initialization.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rastro/slam/orb/tracking/tracked_frame.h"

namespace rastro {
namespace {

std::vector<TrackedPoint> points_of(const MapGraph& graph, std::int64_t keyframe) {
  std::vector<TrackedPoint> points;
  const MapKeyframe& observer = graph.keyframe(keyframe);
  for (std::uint32_t i = 0; i < observer.landmarks.size(); ++i) {
    if (observer.landmarks[i] < 0) continue;
    TrackedPoint point;
    point.feature = i;
    point.landmark = observer.landmarks[i];
    point.position = graph.landmark(point.landmark).position;
    points.push_back(point);
  }
  return points;
}

}  // namespace

Initialization::Initialization(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline,
                               KeyframeInsertion& keyframes)
    : session_(session),
      tracker_(tracker),
      pipeline_(pipeline),
      keyframes_(keyframes),
      initializer_(session.options, session.sensor.camera) {}

void Initialization::process(const std::shared_ptr<const FeatureFrame>& frame, SlamUpdate& update) {
  session_.mono() ? from_two_views(frame, update) : from_depth(frame, update);
}

/// If there is a map, a new submap is started only after relocalization has failed long enough.
bool Initialization::may_begin() const {
  return !session_.has_map || session_.lost_frames >= session_.options.lost_frames;
}

void Initialization::from_two_views(const std::shared_ptr<const FeatureFrame>& frame, SlamUpdate& update) {
  const auto pair = initializer_.add(frame);
  report_waiting(update);
  if (!pair || !may_begin()) return;
  if (!create_map(*pair, update)) return;
  track_kept_frames(*pair);
  update.world_from_body = tracker_.last_pose().inverse();
  trial_frames_ = session_.options.init_trial_frames;
  trial_submap_ = session_.graph.submap(session_.graph.newest_keyframe());
  contradictions_ = 0;
  if (trial_frames_ == 0) initializer_.clear();
}

/// Why tracking was lost says more than what a new submap waits for.
void Initialization::report_waiting(SlamUpdate& update) const {
  if (!session_.has_map) {
    update.reason = initializer_.frames().size() < 2 ? SlamReason::first_frame : SlamReason::too_few_points;
    update.detail = initializer_.detail();
  } else if (update.detail.empty()) {
    update.detail = "a new submap waits: " + initializer_.detail();
  }
}

bool Initialization::create_map(const InitialPair& pair, SlamUpdate& update) {
  pipeline_.take_all_results(update.events);
  const auto first = initializer_.frames()[pair.first]->with_id(session_.next_keyframe);
  const auto second = initializer_.frames()[pair.second]->with_id(session_.next_keyframe + 1);
  session_.next_keyframe += 2;
  const int submap = next_submap();
  if (!pipeline_.local_mapping().initialize(first, second, pair.second_from_first, pair.pairs, pair.points, submap)) {
    update.detail = fmt::format("fewer than {} points left after bundle adjustment", session_.options.init_points);
    return false;
  }
  begin_tracking(second->data().id);
  add_keyframe(*first);
  add_keyframe(*second);
  report(fmt::format("{} started from frames {} and {} with {} points", submap, first->data().frame,
                     second->data().frame, session_.graph.shared(first->data().id, second->data().id)),
         update);
  return true;
}

void Initialization::from_depth(const std::shared_ptr<const FeatureFrame>& frame, SlamUpdate& update) {
  if (!may_begin()) return;
  const auto near = static_cast<int>(keyframes_.new_depth_features(*frame, {}).size());
  if (!has_enough_near(*frame, near, update)) return;
  pipeline_.take_all_results(update.events);
  const auto keyframe = frame->with_id(session_.next_keyframe++);
  const int submap = next_submap();
  pipeline_.local_mapping().initialize(keyframe, submap);
  begin_tracking(keyframe->data().id);
  restart_at(keyframe->data().id);
  add_keyframe(*keyframe);
  report(fmt::format("{} started with {} points", submap, near), update);
  update.world_from_body = SE3();
}

/// Only near depths become landmarks, and tracking needs some.
bool Initialization::has_enough_near(const FeatureFrame& frame, int near, SlamUpdate& update) const {
  const OrbSlamOptions& options = session_.options;
  const auto& depths = frame.data().depths;
  const auto known = std::count_if(depths.begin(), depths.end(), [](float depth) { return depth > 0.0F; });
  const bool enough = known >= options.start_depth_points;
  if (enough && near >= options.min_inliers) return true;
  update.reason = SlamReason::too_few_points;
  update.detail = fmt::format("needs at least {} features with depth, got {}", options.start_depth_points, known);
  if (enough)
    update.detail += fmt::format(", but only {} of them within {:.1f} m, of which {} are needed", near,
                                 options.far_baselines * session_.sensor.baseline, options.min_inliers);
  return false;
}

/// Reuses the number of a dropped map.
int Initialization::next_submap() const {
  if (!session_.has_map) return 0;
  const int newest = session_.graph.submap_count() - 1;
  return session_.graph.keyframe_ids(newest).empty() ? newest : newest + 1;
}

void Initialization::begin_tracking(std::int64_t keyframe) {
  session_.has_map = session_.tracking = true;
  keyframes_.on_initialized();
  tracker_.set_view(view_of(session_.graph, keyframe, session_.view_options()));
}

void Initialization::add_keyframe(const FeatureFrame& frame) {
  session_.trajectory.add(tracked_keyframe(session_.graph, frame, frame.data().id));
}

void Initialization::report(std::string event, SlamUpdate& update) const {
  update.events.push_back({"submap", std::move(event)});
  update.state = SlamState::tracking;
  update.reason = SlamReason::none;
  if (session_.mono()) update.detail.clear();
}

/// Tracks the frames before the first view, those between both, and those after the second.
void Initialization::track_kept_frames(const InitialPair& pair) {
  const std::int64_t first = session_.graph.keyframe_ids().back() - 1, second = first + 1;
  const auto& frames = initializer_.frames();
  restart_at(first);
  track_backward(pair.first);
  restart_at(first);
  for (std::size_t i = pair.first + 1; i < pair.second; ++i) {
    const TrackingResult tracked = tracker_.track(frames[i]);
    if (tracked.ok) add_frame(*frames[i], tracked);
  }
  if (tracker_.track(frames[pair.second]).ok) return;
  restart_at(session_.graph.has_keyframe(second) ? second : first);  // keyframes before the first may have replaced it
}

void Initialization::track_backward(std::size_t first) {
  const auto& frames = initializer_.frames();
  for (std::size_t i = first; i-- > 0;) {
    const TrackingResult tracked = tracker_.track(frames[i]);
    if (!tracked.ok) break;
    add_frame(*frames[i], tracked);
    if (keyframes_.needs_keyframe(*frames[i], tracked)) keyframes_.insert_now(frames[i], tracked);
  }
}

void Initialization::restart_at(std::int64_t id) {
  const MapKeyframe& keyframe = session_.graph.keyframe(id);
  tracker_.restart(keyframe.camera_from_world, points_of(session_.graph, id), keyframe.frame);
}

void Initialization::add_frame(const FeatureFrame& frame, const TrackingResult& tracked) {
  session_.trajectory.add(
      tracked_frame(session_.graph, *tracker_.view(), frame, tracked, session_.options.pixel_sigma));
}

/// Two views may agree on a wrong motion, for example near a plane; the following frames contradict it.
bool Initialization::is_contradicted_by(const std::shared_ptr<const FeatureFrame>& frame,
                                        const TrackingResult& tracked) {
  constexpr int max_contradictions = 3;
  if (trial_frames_ == 0) return false;
  // Joined to another submap, it is no longer a start that could be dropped.
  if (!session_.mapping || tracker_.view()->keyframe(tracked.reference).submap != trial_submap_) {
    reset();
    return false;
  }
  contradictions_ = tracked.mean_squared > session_.options.init_max_error ? contradictions_ + 1 : 0;
  if (contradictions_ == max_contradictions) return true;
  initializer_.keep(frame);
  if (--trial_frames_ == 0) initializer_.clear();
  return false;
}

bool Initialization::drop_map(const TrackingResult& tracked, SlamUpdate& update) {
  pipeline_.take_all_results(update.events);
  MapGraph& graph = session_.graph;
  const int submap = trial_submap_;
  if (graph.submap(tracked.reference) != submap) {
    reset();
    return false;
  }
  session_.trajectory.forget(graph, submap);
  const std::vector<std::int64_t> keyframes = graph.keyframe_ids(submap);
  for (const std::int64_t id : keyframes) {
    if (graph.keyframe(id).parent >= 0) graph.remove_keyframe(id);
  }
  for (const std::int64_t id : graph.keyframe_ids(submap)) graph.remove_root(id);
  session_.tracking = false;
  session_.has_map = graph.keyframe_count() > 0;
  session_.lost_frames = session_.has_map ? session_.options.lost_frames : 0;
  trial_frames_ = contradictions_ = 0;
  keyframes_.forget_observations();
  update.events.push_back(
      {"start_dropped", fmt::format("submap {} contradicts the frames after it: mean squared error {:.1f}, at most "
                                    "{:.1f}; initialization begins again",
                                    submap, tracked.mean_squared, session_.options.init_max_error)});
  return true;
}

void Initialization::reset() {
  trial_frames_ = 0;
  initializer_.clear();
}

}  // namespace rastro
