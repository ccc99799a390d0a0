// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "rastro/slam/orb/orb_slam_state.h"

namespace rastro {

void OrbSlam::State::place(const FeatureFrame& frame, const TrackResult& tracked) {
  const MapView& view = *tracker_.view();
  const auto& reference = view.keyframes[static_cast<std::size_t>(view.find_keyframe(tracked.reference))];
  PlacedFrame placed{frame.data().frame,
                     frame.data().stamp,
                     reference.id,
                     tracked.camera_from_world * reference.camera_from_world.inverse(),
                     reference.unit,
                     -1,
                     {}};
  for (const TrackedPoint& point : tracked.points) {
    if (point.landmark < 0) continue;
    placed.seen.push_back({point.landmark, frame.ray(point.feature).cast<float>(),
                           static_cast<float>(frame.right_ray(point.feature)),
                           static_cast<float>(options_.pixel_sigma * graph_.sigma(frame, point.feature))});
  }
  way_.add(placed);
}

void OrbSlam::State::place_keyframe(const FeatureFrame& frame, std::int64_t keyframe) {
  way_.add({frame.data().frame, frame.data().stamp, keyframe, SE3(), graph_.unit(keyframe), keyframe, {}});
}

void OrbSlam::State::count_seen(const TrackResult& tracked) {
  visible_.insert(visible_.end(), tracked.visible.begin(), tracked.visible.end());
  for (const TrackedPoint& point : tracked.points) {
    if (point.landmark >= 0) found_.push_back(point.landmark);
  }
}

bool OrbSlam::State::needs_keyframe(const FeatureFrame& frame, const TrackResult& tracked) const {
  if (settled_seen_ > 0 && seen_ - settled_seen_ < options_.settled_frames) return false;
  const bool overdue = seen_ - keyframe_seen_ > options_.keyframe_frames;
  if (!pending_.empty() && !overdue) return false;
  const MapView& view = *tracker_.view();
  const auto& reference = view.keyframes[static_cast<std::size_t>(view.find_keyframe(tracked.reference))];
  const bool mono = sensor_.sensor == CameraKind::mono;
  const double share = mono ? options_.keyframe_share : options_.keyframe_share_depth;
  if (tracked.inliers < share * reference.landmarks || (overdue && tracked.inliers < reference.landmarks)) return true;
  // Where depth is seen, new ground may come into view while the old is still tracked well.
  if (mono || tracked.inliers >= options_.keyframe_few_points) return false;
  return fresh_features(frame, tracked).size() > static_cast<std::size_t>(options_.keyframe_new_points);
}

std::vector<std::uint32_t> OrbSlam::State::fresh_features(const FeatureFrame& frame, const TrackResult& tracked) const {
  std::vector<std::uint32_t> fresh;
  if (sensor_.sensor == CameraKind::mono) return fresh;
  std::vector<std::uint8_t> taken(frame.size(), 0);
  for (const TrackedPoint& point : tracked.points) taken[point.feature] = 1;
  const double far = options_.far_baselines * sensor_.baseline;
  for (std::uint32_t i = 0; i < frame.size(); ++i) {
    if (taken[i] == 0 && std::isfinite(frame.right_pixel(i)) && static_cast<double>(frame.data().depths[i]) <= far)
      fresh.push_back(i);
  }
  return fresh;
}

KeyframeInput OrbSlam::State::keyframe_input(const FramePointer& frame, const TrackResult& tracked) {
  const MapView& view = *tracker_.view();
  const auto& reference = view.keyframes[static_cast<std::size_t>(view.find_keyframe(tracked.reference))];
  KeyframeInput input{frame->with_id(next_keyframe_++),
                      reference.id,
                      tracked.camera_from_world * reference.camera_from_world.inverse(),
                      reference.unit,
                      tracked.points,
                      std::move(visible_),
                      std::move(found_)};
  visible_.clear();
  found_.clear();
  keyframe_seen_ = seen_;
  way_.set_keyframe(frame->data().frame, input.frame->data().id);
  return input;
}

void OrbSlam::State::make_keyframe(const FramePointer& frame, const TrackResult& tracked, SlamUpdate& update) {
  const auto input = std::make_shared<KeyframeInput>(keyframe_input(frame, tracked));
  const std::int64_t id = input->frame->data().id;
  tracker_.add_fresh(id, input->frame, tracked.camera_from_world, fresh_features(*frame, tracked));
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  const auto result = std::make_shared<MappingResult>();
  const std::size_t job = background_.submit([this, input, result, id] {
    mapper_.add(*input);
    if (options_.loop_closing) {
      if (const auto loop = closer_.consider(id)) {
        result->events.push_back(loop->event());
        if (options_.loop_adjust_iterations > 0)
          result->adjustment =
              std::make_shared<SubmapAdjustment>(graph_, graph_.keyframe(id).submap, options_.pixel_sigma);
      }
    }
    result->view = view_of(graph_, id, view_options());
  });
  const TimeNs due_stamp = frame->data().stamp + from_seconds(options_.backend_delay_s);
  pending_.push_back({seen_ + options_.backend_delay_frames, due_stamp, job, result});
}

/// The same without a later frame to hand the result over to.
void OrbSlam::State::map_now(const FramePointer& frame, const TrackResult& tracked) {
  const KeyframeInput input = keyframe_input(frame, tracked);
  mapper_.add(input);
  tracker_.set_view(view_of(graph_, input.frame->data().id, view_options()));
}

/// Where stamps stand still, frames alone count.
bool OrbSlam::State::is_due(std::int64_t due, TimeNs due_stamp, int frames_at_most, TimeNs stamp) const {
  return due <= seen_ && (due_stamp <= stamp || due + frames_at_most <= seen_);
}

void OrbSlam::State::take_results(TimeNs stamp, std::vector<SlamEvent>& events) {
  if (adjustment_ && is_due(adjustment_->due, adjustment_->due_stamp, 20 * options_.keyframe_frames, stamp))
    take_adjustment(stamp);
  while (!pending_.empty() && is_due(pending_.front().due, pending_.front().due_stamp, options_.keyframe_frames, stamp))
    take_next_result(events);
}

void OrbSlam::State::take_all_results(std::vector<SlamEvent>& events) {
  while (!pending_.empty()) take_next_result(events);
}

void OrbSlam::State::take_next_result(std::vector<SlamEvent>& events) {
  const Pending pending = pending_.front();
  pending_.pop_front();
  background_.wait(pending.job);
  events.insert(events.end(), pending.result->events.begin(), pending.result->events.end());
  if (tracking_ && pending.result->view) tracker_.set_view(pending.result->view);
  if (pending.result->adjustment) begin_adjustment(pending.result->adjustment);
  keep_map();
}

/// What is under way no longer fits a map that has been corrected again.
void OrbSlam::State::begin_adjustment(const std::shared_ptr<SubmapAdjustment>& work) {
  drop_adjustment();
  const double delay_s = options_.loop_adjust_delay_s * static_cast<double>(work->observations()) / 1e5;
  const std::size_t job =
      adjusting_.submit([this, work] { work->run(options_.loop_adjust_iterations, stop_, &adjusting_pool_); });
  adjustment_ = {seen_ + options_.backend_delay_frames, last_stamp_ + from_seconds(delay_s), job, work};
}

/// Mapping carries the adjusted submap over, in turn with the keyframes.
void OrbSlam::State::take_adjustment(TimeNs stamp) {
  const std::shared_ptr<SubmapAdjustment> work = adjustment_->work;
  adjusting_.wait(adjustment_->job);
  adjustment_.reset();
  const auto result = std::make_shared<MappingResult>();
  result->events.push_back({"adjusted", work->detail()});
  const std::int64_t centre = tracking_ ? tracker_.view()->centre : -1;
  const std::size_t job = background_.submit([this, work, result, centre] {
    work->apply(graph_);
    if (graph_.has_keyframe(centre)) result->view = view_of(graph_, centre, view_options());
  });
  pending_.push_back(
      {seen_ + options_.backend_delay_frames, stamp + from_seconds(options_.backend_delay_s), job, result});
}

void OrbSlam::State::drop_adjustment() {
  if (adjustment_) adjustment_->work->cancel();
  adjustment_.reset();
}

}  // namespace rastro
