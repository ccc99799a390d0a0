// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/keyframe_insertion.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace rastro {

/// Where the landmarks run out, the camera would be lost again before it has settled.
bool KeyframeInsertion::is_settled(const TrackingResult& tracked) const {
  if (relocalized_frame_ == 0) return true;
  return session_.frame_number - relocalized_frame_ >= session_.options.settled_frames ||
         2 * tracked.inliers < relocalized_inliers_;
}

bool KeyframeInsertion::needs_keyframe(const FeatureFrame& frame, const TrackingResult& tracked) const {
  const OrbSlamOptions& options = session_.options;
  const std::int64_t now = session_.frame_number;
  if (!is_settled(tracked)) return false;
  const bool overdue = static_cast<double>(now - keyframe_frame_) > session_.spacing * options.keyframe_frames;
  if (!pipeline_.settled(frame.data().stamp) && !overdue) return false;
  const int landmarks = tracker_.view()->keyframe(tracked.reference).landmarks;
  const double share =
      session_.keyframe_share * (session_.mono() ? options.keyframe_share : options.keyframe_share_depth);
  if (tracked.inliers < share * landmarks || (overdue && tracked.inliers < landmarks)) return true;
  // With depth, new areas may come into view while old ones are still tracked well.
  if (session_.mono() || tracked.inliers >= options.keyframe_few_points) return false;
  return new_depth_features(frame, tracked).size() > static_cast<std::size_t>(options.keyframe_new_points);
}

std::vector<std::uint32_t> KeyframeInsertion::new_depth_features(const FeatureFrame& frame,
                                                                 const TrackingResult& tracked) const {
  std::vector<std::uint32_t> features;
  if (session_.mono()) return features;
  std::vector<std::uint8_t> taken(frame.size(), 0);
  for (const TrackedPoint& point : tracked.points) taken[point.feature] = 1;
  const double far = session_.options.far_baselines * session_.sensor.baseline;
  for (std::uint32_t i = 0; i < frame.size(); ++i) {
    if (taken[i] == 0 && std::isfinite(frame.right_pixel(i)) && static_cast<double>(frame.data().depths[i]) <= far)
      features.push_back(i);
  }
  return features;
}

std::vector<std::uint32_t> KeyframeInsertion::insert(const std::shared_ptr<const FeatureFrame>& frame,
                                                     const TrackingResult& tracked, SlamUpdate& update,
                                                     std::shared_ptr<const DirectView> view) {
  if (!pipeline_.accepts()) return {};
  auto input = std::make_shared<KeyframeInput>(input_of(*frame, tracked));
  input->view = std::move(view);
  const std::int64_t id = input->frame->data().id;
  std::vector<std::uint32_t> fresh = new_depth_features(*frame, tracked);
  tracker_.add_depth_points(id, input->frame, tracked.camera_from_world, fresh);
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  pipeline_.insert(std::move(input), frame->data().stamp);
  return fresh;
}

void KeyframeInsertion::insert_now(const std::shared_ptr<const FeatureFrame>& frame, const TrackingResult& tracked) {
  pipeline_.insert_now(input_of(*frame, tracked));
}

KeyframeInput KeyframeInsertion::input_of(const FeatureFrame& frame, const TrackingResult& tracked) {
  const MapView::Keyframe& reference = tracker_.view()->keyframe(tracked.reference);
  KeyframeInput input{frame.with_id(session_.next_keyframe++),
                      reference.id,
                      tracked.camera_from_world * reference.camera_from_world.inverse(),
                      reference.unit,
                      tracked.points,
                      std::move(counts_)};
  forget_observations();
  keyframe_frame_ = session_.frame_number;
  session_.trajectory.set_keyframe(frame.data().frame, input.frame->data().id);
  return input;
}

void KeyframeInsertion::count_observations(const TrackingResult& tracked) {
  for (const std::int64_t landmark : tracked.visible) ++counts_[landmark].visible;
  for (const TrackedPoint& point : tracked.points) {
    if (point.landmark >= 0) ++counts_[point.landmark].found;
  }
}

void KeyframeInsertion::forget_observations() { counts_.clear(); }

void KeyframeInsertion::on_relocalized(int inliers) {
  relocalized_frame_ = session_.frame_number;
  relocalized_inliers_ = inliers;
}

void KeyframeInsertion::on_initialized() {
  keyframe_frame_ = session_.frame_number;
  relocalized_frame_ = 0;
}

}  // namespace rastro
