// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/orb_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/stopwatch.h"
#include "rastro/slam/orb/orb_slam_state.h"

namespace rastro {
namespace {

SlamReason reason_of(OdometryReason reason) {
  if (reason == OdometryReason::dark_or_blank) return SlamReason::dark_or_blank;
  if (reason == OdometryReason::repeated_frame) return SlamReason::repeated_frame;
  if (reason == OdometryReason::blurred) return SlamReason::blurred;
  if (reason == OdometryReason::gap) return SlamReason::gap;
  return SlamReason::none;
}

/// Of d in truth = exp(d) * camera_from_world to errors of world_from_camera in the world's axes.
Matrix6d in_world_axes(const Matrix6d& covariance, const SE3& camera_from_world) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = camera_from_world.rotation().inverse().matrix();
  const Matrix6d turned = turn * covariance * turn.transpose();
  return 0.5 * (turned + turned.transpose());
}

}  // namespace

OrbSlam::State::State(const OrbSlamOptions& options, const SourceInfo& source, const SlamContext& context)
    : options_(options_for(options, source, context.map.get())),
      sensor_(choose_sensor(options_, source)),
      check_(options_.frame_check),
      maker_(options_, sensor_, context.pool),
      graph_(sensor_.camera, sensor_.sensor, sensor_.baseline, orb_options(options_)),
      adjusting_pool_(context.pool ? context.pool->threads() : 1, TaskPriority::low),
      mapping_pool_(context.pool ? context.pool->threads() : 1, TaskPriority::low),
      mapper_(options_, graph_, &mapping_pool_, context.stop),
      places_(graph_, standard_vocabulary()),
      closer_(options_, graph_, places_),
      relocaliser_(options_, graph_, places_),
      tracker_(options_, sensor_.camera, sensor_.sensor, sensor_.baseline),
      initialiser_(options_, sensor_.camera),
      archive_(context.archive),
      stop_(context.stop),
      background_(context.pipelined && context.pool != nullptr && context.pool->threads() > 1),
      adjusting_(context.pipelined && context.pool != nullptr && context.pool->threads() > 1) {
  if (sensor_.rectification) rectifier_.emplace(sensor_.rectification, context.pool);
  if (options_.frontend == "tracks") tracks_.emplace(options_, sensor_.camera, context.pool);
  if (context.map) use_map(context);
}

void OrbSlam::State::use_map(const SlamContext& context) {
  const Map& map = *context.map;
  check_map(map, sensor_, context.extend_map);
  restore(map, sensor_.baseline, graph_);
  places_.update();
  scale_ = scale_of(map);
  maps_ = context.extend_map;
  exists_ = !map.keyframes.empty();
  next_keyframe_ = map.keyframes.empty() ? 0 : map.keyframes.back().id + 1;
}

void OrbSlam::State::keep_map() {
  if (archive_ != nullptr && maps_ && pending_.empty() && archive_->wants_map())
    archive_->keep(map_of(graph_, way_, scale_));
}

SlamUpdate OrbSlam::State::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  ++seen_;
  update.world_from_body = last_pose_;
  take_results(frame.stamp, update.events);
  update.times.push_back({"wait", stage.lap_ms()});
  check_and_look(frame, update);
  last_pose_ = update.world_from_body;
  update.world_from_body = update.world_from_body * sensor_.camera_from_left();
  if (exists_) keep_map();
  update.milliseconds = whole.lap_ms();
  return update;
}

void OrbSlam::State::check_and_look(const Frame& frame, SlamUpdate& update) {
  const FrameCheckResult checked = check_.check(frame.image.view(), frame.stamp);
  update.reason = reason_of(checked.reason);
  update.detail = checked.detail;
  if (!checked.useful() && checked.reason != OdometryReason::blurred) {
    update.state = exists_ ? SlamState::lost : SlamState::initialising;
    if (frame.image.empty()) update.reason = SlamReason::no_data;
    const bool repeated = tracking_ && checked.reason == OdometryReason::repeated_frame;
    if (repeated && way_.repeat_last(frame.index, frame.stamp)) update.state = SlamState::tracking;
    return;
  }
  if (!rectifier_) return look(frame, update);
  Stopwatch stage;
  const Frame rectified = rectifier_->rectified(frame);
  update.times.push_back({"rectify", stage.lap_ms()});
  look(rectified, update);
}

void OrbSlam::State::look(const Frame& frame, SlamUpdate& update) {
  Stopwatch stage;
  const FramePointer features = maker_.make(frame, depth_from_colour(frame));
  last_stamp_ = frame.stamp;
  update.times.push_back({"features", stage.lap_ms()});
  std::vector<FollowedLandmark> followed;
  if (tracks_) {
    followed = tracks_->follow(frame);
    update.times.push_back({"tracks", stage.lap_ms()});
  }
  if (tracking_) {
    follow(features, followed, update);
  } else {
    on_loss(features, update);
  }
}

/// Depth cameras take both pictures at different instants; the last motion is carried on from one to the other.
SE3 OrbSlam::State::depth_from_colour(const Frame& frame) const {
  const double interval = to_seconds(frame.stamp - last_stamp_), offset = to_seconds(frame.depth_stamp - frame.stamp);
  if (!tracking_ || frame.depth.empty() || !(interval > 0.0) || std::abs(offset) > interval) return {};
  return SE3::exp(offset / interval * tracker_.velocity().log());
}

void OrbSlam::State::follow(const FramePointer& frame, const std::vector<FollowedLandmark>& followed,
                            SlamUpdate& update) {
  Stopwatch stage;
  const TrackResult tracked = tracker_.track(frame, followed);
  update.times.push_back({"track", stage.lap_ms()});
  if (tracked.ok && proves_wrong(frame, tracked)) {
    drop_start(tracked, update);
    return on_loss(frame, update);
  }
  if (tracked.ok) {
    update.state = SlamState::tracking;
    return on_pose(frame, tracked, update);
  }
  update.reason = SlamReason::few_inliers;
  update.detail = fmt::format("{} of {} matches fit, need {}", tracked.inliers, tracked.matches, options_.min_inliers);
  update.world_from_body = tracker_.predicted().inverse();
  tracking_ = false;
  lost_frames_ = trial_frames_ = 0;
  initialiser_.clear();
  on_loss(frame, update);
}

void OrbSlam::State::on_pose(const FramePointer& frame, const TrackResult& tracked, SlamUpdate& update) {
  Stopwatch stage;
  update.world_from_body = tracked.camera_from_world.inverse();
  update.covariance = in_world_axes(tracked.covariance, tracked.camera_from_world);
  update.score = static_cast<double>(tracked.inliers) / std::max(1, tracked.matches);
  update.used = tracked.inliers;
  place(*frame, tracked);
  count_seen(tracked);
  if (tracks_) tracks_->learn(*frame, tracked.points);
  say_submap(tracked, update);
  if (!maps_) {
    follow_reference(tracked);
  } else if (needs_keyframe(*frame, tracked)) {
    make_keyframe(frame, tracked, update);
  }
  update.times.push_back({"keyframe", stage.lap_ms()});
}

void OrbSlam::State::say_submap(const TrackResult& tracked, SlamUpdate& update) const {
  const MapView& view = *tracker_.view();
  const int submap = view.keyframes[static_cast<std::size_t>(view.find_keyframe(tracked.reference))].submap;
  if (submap == 0) return;
  if (update.state == SlamState::tracking) update.state = SlamState::weak;
  update.reason = SlamReason::apart;
  update.detail = fmt::format("in submap {}, not tied to the first yet", submap);
}

/// Without mapping, the view goes where the camera goes.
void OrbSlam::State::follow_reference(const TrackResult& tracked) {
  visible_.clear();
  found_.clear();
  if (tracked.reference != tracker_.view()->centre)
    tracker_.set_view(view_of(graph_, tracked.reference, view_options()));
}

std::vector<SlamEvent> OrbSlam::State::finish() {
  std::vector<SlamEvent> events;
  take_all_results(events);
  const bool in_haste = stop_ != nullptr && stop_->load();
  if (in_haste) {
    drop_adjustment();
  } else if (adjustment_) {
    take_adjustment(last_stamp_);
    take_all_results(events);
  }
  wait_for_mapping();
  if (!exists_) return events;
  if (maps_ && !in_haste && options_.final_iterations > 0 &&
      graph_.keyframe_count() <= static_cast<std::size_t>(options_.final_keyframes)) {
    for (int submap = 0; submap < graph_.submap_count(); ++submap)
      mapper_.adjust_all(submap, options_.final_iterations);
  }
  way_.settle(graph_, options_.min_inliers / 2);
  keep_map();
  return events;
}

Trajectory OrbSlam::State::trajectory() const {
  wait_for_mapping();
  if (!exists_) return {};
  Trajectory trajectory = way_.trajectory(graph_, way_.largest_submap(graph_));
  for (StampedPose& pose : trajectory) pose.world_from_body = pose.world_from_body * sensor_.camera_from_left();
  return trajectory;
}

std::shared_ptr<const Map> OrbSlam::State::snapshot() const {
  wait_for_mapping();
  return map_of(graph_, way_, scale_);
}

OrbSlam::OrbSlam(const OrbSlamOptions& options, const SourceInfo& source, const SlamContext& context)
    : state_(std::make_unique<State>(options, source, context)) {}

OrbSlam::~OrbSlam() = default;
SlamUpdate OrbSlam::process(const Frame& frame) { return state_->process(frame); }
std::vector<SlamEvent> OrbSlam::finish() { return state_->finish(); }
Trajectory OrbSlam::trajectory() const { return state_->trajectory(); }

std::shared_ptr<const Map> OrbSlam::snapshot() const { return state_->snapshot(); }

}  // namespace rastro
