// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/tracking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/base/stopwatch.h"
#include "rastro/slam/orb/tracking/tracked_frame.h"

namespace rastro {
namespace {

SlamReason reason_of(OdometryReason reason) {
  if (reason == OdometryReason::dark_or_blank) return SlamReason::dark_or_blank;
  if (reason == OdometryReason::repeated_frame) return SlamReason::repeated_frame;
  if (reason == OdometryReason::blurred) return SlamReason::blurred;
  if (reason == OdometryReason::gap) return SlamReason::gap;
  return SlamReason::none;
}

/// From the covariance of d in true pose = exp(d) * camera_from_world to errors of world_from_camera in the world's
/// axes.
Matrix6d in_world_axes(const Matrix6d& covariance, const SE3& camera_from_world) {
  Matrix6d rotation = Matrix6d::Zero();
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = camera_from_world.rotation().inverse().matrix();
  const Matrix6d rotated = rotation * covariance * rotation.transpose();
  return 0.5 * (rotated + rotated.transpose());
}

}  // namespace

Tracking::Tracking(OrbSession& session, FrameTracker& tracker, KeyframePipeline& pipeline, TaskPool* pool)
    : session_(session),
      tracker_(tracker),
      pipeline_(pipeline),
      check_(session.options.frame_check),
      extractor_(session.options, session.sensor, pool),
      feature_count_(session.options, session.mono()),
      keyframes_(session, tracker, pipeline),
      initialization_(session, tracker, pipeline, keyframes_),
      relocalization_(session, tracker, pipeline, keyframes_),
      jump_check_(session.mono() ? 0.0 : session.options.max_acceleration) {
  if (session.sensor.rectification) rectifier_.emplace(session.sensor.rectification, pool);
  if (session.options.frontend == "tracks") tracks_.emplace(session.options, session.sensor.camera, pool);
}

void Tracking::process(const Frame& frame, SlamUpdate& update) {
  if (!is_usable(frame, update)) return;
  const Measurements measured = extract_features(frame, update);
  observations_.clear();
  for (const Keypoint& keypoint : measured.features->data().features.keypoints)
    observations_.push_back({{keypoint.x, keypoint.y}, -1, ObservationState::unmatched});
  tracker_.set_min_inliers(session_.min_inliers());
  if (waits_for_rotation(measured.features, update)) return;
  std::optional<TrackingResult> tracked;
  if (session_.tracking) tracked = track_map(measured, update);
  if (!tracked) tracked = relocalize(measured.features, update);
  if (!tracked) return initialize(measured, update);
  if (relocalization_.is_unconfirmed() && !confirm(measured.features, *tracked, update)) {
    // A place that only looks alike may be found again and again: a new submap must not wait for that to end.
    if (!session_.tracking) initialize(measured, update);
    return;
  }
  Stopwatch stage;
  observe(*tracked, ObservationState::inlier, ObservationState::outlier);
  report_pose(*measured.features, *tracked, update);
  insert_keyframe(measured, *tracked, update);
  report_submap(tracker_.view()->keyframe(tracked->reference).submap, update);
  update.times.push_back({"keyframe", stage.lap_ms()});
}

bool Tracking::is_usable(const Frame& frame, SlamUpdate& update) {
  const FrameCheckResult checked = check_.check(frame.image.view(), frame.stamp);
  update.reason = reason_of(checked.reason);
  update.detail = checked.detail;
  if (checked.useful() || checked.reason == OdometryReason::blurred) return true;
  update.state = session_.has_map ? SlamState::lost : SlamState::initializing;
  if (frame.image.empty()) update.reason = SlamReason::no_data;
  const bool repeated = follows_map() && checked.reason == OdometryReason::repeated_frame;
  if (repeated && session_.trajectory.repeat_last(frame.index, frame.stamp)) update.state = SlamState::weak;
  return false;
}

Tracking::Measurements Tracking::extract_features(const Frame& recorded, SlamUpdate& update) {
  Stopwatch stage;
  std::optional<Frame> rectified;
  if (rectifier_) {
    rectified = rectifier_->rectified(recorded);
    update.times.push_back({"rectify", stage.lap_ms()});
  }
  const Frame& frame = rectified ? *rectified : recorded;
  Measurements measured;
  extractor_.set_features(feature_count_.next());
  measured.features = extractor_.make(frame, depth_from_color(frame));
  update.times.push_back({"features", stage.lap_ms()});
  if (session_.direct.alignment && session_.mapping) {
    measured.view = session_.direct.alignment->view_of(frame, depth_from_color(frame));
    update.times.push_back({"view", stage.lap_ms()});
  }
  session_.last_stamp = frame.stamp;
  if (tracks_) {
    measured.tracks = tracks_->follow(frame);
    update.times.push_back({"tracks", stage.lap_ms()});
  }
  return measured;
}

/// Depth cameras capture both images at different instants; the last motion is extrapolated from one to the other.
SE3 Tracking::depth_from_color(const Frame& frame) const {
  const double interval = to_seconds(frame.stamp - session_.last_stamp);
  const double offset = to_seconds(frame.depth_stamp - frame.stamp);
  if (!session_.tracking || frame.depth.empty() || !(interval > 0.0) || std::abs(offset) > interval) return {};
  return SE3::exp(offset / interval * tracker_.velocity().log());
}

/// With a rolling shutter the first frame of a map waits for the second, which shows how the camera rotates.
bool Tracking::waits_for_rotation(const FramePointer& frame, SlamUpdate& update) {
  if (!session_.mapping || session_.has_map) return false;
  if (first_) {
    const FramePointer first = std::exchange(first_, nullptr);
    initialization_.process(extractor_.is_rotation_known() ? extractor_.with_rotation(*first) : first, update);
    return false;
  }
  if (extractor_.is_rotation_known()) return false;
  first_ = frame;
  update.state = SlamState::initializing;
  update.reason = SlamReason::first_frame;
  update.detail = "the next frame shows how far the camera rotates while it reads an image";
  return true;
}

/// Tracks in the local map, from the pose predicted by constant velocity or the reference keyframe.
std::optional<TrackingResult> Tracking::track_map(const Measurements& measured, SlamUpdate& update) {
  Stopwatch stage;
  const SE3 predicted = tracker_.predicted();
  TrackingResult tracked = tracker_.track(measured.features, measured.tracks);
  update.times.push_back({"track", stage.lap_ms()});
  if (!tracked.ok) {
    observe(tracked, ObservationState::matched, ObservationState::matched);
    relocalization_.is_unconfirmed() ? relocalization_.reject() : on_lost(tracked, update);
    return std::nullopt;
  }
  if (is_dropped_start(measured, tracked, update)) return std::nullopt;
  if (jumps_in_given_map(tracked, predicted, update)) return std::nullopt;
  align(measured, tracked, update);
  update.state = SlamState::tracking;
  // The trial of a new map compares frames with the features that it began with.
  if (session_.mapping && !initialization_.is_on_trial()) feature_count_.on_tracked(tracked.inliers);
  return tracked;
}

/// Whether the map on trial is dropped. A submap that was joined just now stays, and the frame is tracked in its world.
bool Tracking::is_dropped_start(const Measurements& measured, TrackingResult& tracked, SlamUpdate& update) {
  if (!initialization_.is_contradicted_by(measured.features, tracked)) return false;
  if (initialization_.drop_map(tracked, update)) return true;
  tracked = tracker_.track_from(measured.features, tracker_.last_pose());
  if (!tracked.ok) on_lost(tracked, update);
  return !tracked.ok;
}

/// Refines the pose by the pixels of the whole image, against the keyframe that shares most landmarks or, while that
/// one is not mapped yet, the newest one in the view.
void Tracking::align(const Measurements& measured, TrackingResult& tracked, SlamUpdate& update) {
  if (!measured.view) return;
  Stopwatch stage;
  const std::vector<MapView::Keyframe>& keyframes = tracker_.view()->keyframes;
  const MapView::Keyframe* keyframe = &tracker_.view()->keyframe(tracked.reference);
  for (auto at = keyframes.rbegin(); at != keyframes.rend() && !session_.direct.keyframes.find(keyframe->id); ++at)
    keyframe = &*at;
  const DirectView* known = session_.direct.keyframes.find(keyframe->id);
  const RelativePose by_features{tracked.camera_from_world * keyframe->camera_from_world.inverse(), tracked.covariance};
  const auto aligned = known == nullptr
                           ? std::nullopt
                           : session_.direct.alignment->align(*known, *measured.view, by_features.camera_from_keyframe);
  if (aligned) {
    const RelativePose both = fused(by_features, *aligned);
    tracked.direct = std::make_shared<DirectObservation>(DirectObservation{keyframe->id, *aligned});
    tracked.camera_from_world = both.camera_from_keyframe * keyframe->camera_from_world;
    tracked.covariance = both.covariance;
    tracker_.correct(tracked.camera_from_world);
  }
  update.times.push_back({"align", stage.lap_ms()});
}

/// A map that is being made has its own errors, and corrects them: there the pose is only weak (MotionCheck).
bool Tracking::jumps_in_given_map(const TrackingResult& tracked, const SE3& predicted, SlamUpdate& update) {
  if (session_.mapping || relocalization_.is_unconfirmed()) return false;
  if (!jump_check_.jumps(update.stamp, predicted, tracked.camera_from_world, tracked.covariance)) return false;
  observe(tracked, ObservationState::matched, ObservationState::matched);
  on_lost(tracked, update);
  update.reason = SlamReason::implausible_motion;
  update.detail =
      fmt::format("the pose is {:.2f} m from where the motion so far leads, with {} inliers of {} matches",
                  (tracked.camera_from_world.inverse().translation() - predicted.inverse().translation()).norm(),
                  tracked.inliers, tracked.matches);
  return true;
}

std::string Tracking::why_lost(const TrackingResult& tracked) const {
  const int least = session_.min_inliers();
  if (tracked.inliers < least)
    return fmt::format("needs at least {} inliers, got {} of {} matches", least, tracked.inliers, tracked.matches);
  if (tracked.supporting < least)
    return fmt::format("needs at least {} landmarks whose distance is known to {:.0f} %, got {} of {} inliers", least,
                       100.0 * session_.options.localization_distance_error, tracked.supporting, tracked.inliers);
  return fmt::format("only {} inliers where {:.0f} fit a wrong pose by chance", tracked.inliers,
                     tracked.chance_inliers);
}

void Tracking::on_lost(const TrackingResult& tracked, SlamUpdate& update) {
  update.reason = SlamReason::few_inliers;
  update.detail = why_lost(tracked);
  update.world_from_body = tracker_.predicted().inverse();
  relocalization_.on_lost();
  jump_check_.reset();
  feature_count_.on_lost();
  session_.tracking = false;
  session_.lost_frames = 0;
  initialization_.reset();
}

std::optional<TrackingResult> Tracking::relocalize(const FramePointer& frame, SlamUpdate& update) {
  ++session_.lost_frames;
  update.state = session_.has_map ? SlamState::lost : SlamState::initializing;
  if (!session_.has_map) return std::nullopt;
  if (update.reason == SlamReason::none) update.reason = SlamReason::not_found;
  Stopwatch stage;
  auto tracked = relocalization_.relocalize(frame, update.events);
  update.times.push_back({"relocalize", stage.lap_ms()});
  return tracked;
}

bool Tracking::follows_map() const { return session_.tracking && !relocalization_.is_unconfirmed(); }

bool Tracking::confirm(const FramePointer& frame, const TrackingResult& tracked, SlamUpdate& update) {
  if (!relocalization_.confirm(frame, tracked, update)) {
    observe(tracked, ObservationState::matched, ObservationState::matched);
    return false;
  }
  initialization_.reset();
  return true;
}

void Tracking::initialize(const Measurements& measured, SlamUpdate& update) {
  if (!session_.mapping) return;
  Stopwatch stage;
  initialization_.process(measured.features, update);
  if (session_.tracking) observe_first_landmarks(*measured.features);
  if (session_.tracking) report_submap(session_.graph.submap(session_.graph.newest_keyframe()), update);
  if (session_.tracking && measured.view) {
    const std::int64_t first = session_.graph.newest_keyframe();
    session_.direct.keyframes.add(first, pipeline_.local_mapping().add_view(first, measured.view.get()));
  }
  update.times.push_back({"start", stage.lap_ms()});
}

void Tracking::report_pose(const FeatureFrame& frame, const TrackingResult& tracked, SlamUpdate& update) {
  update.world_from_body = tracked.camera_from_world.inverse();
  update.covariance = session_.uncertainty.of_pose(tracked.reference, update.world_from_body.translation(),
                                                   in_world_axes(tracked.covariance, tracked.camera_from_world));
  update.score = static_cast<double>(tracked.inliers) / std::max(1, tracked.matches);
  update.used = tracked.inliers;
  session_.trajectory.add(
      tracked_frame(session_.graph, *tracker_.view(), frame, tracked, session_.options.pixel_sigma));
  if (tracks_) tracks_->learn(frame, tracked.points);
  report_contradiction(tracked, update);
}

/// With many inliers a pose is right, whatever else moves.
void Tracking::report_contradiction(const TrackingResult& tracked, SlamUpdate& update) const {
  const bool few = tracked.inliers < session_.options.weak_inliers;
  if (update.state != SlamState::tracking || !few || update.score >= session_.options.weak_share) return;
  update.state = SlamState::weak;
  update.reason = SlamReason::few_inliers;
  update.detail = fmt::format("only {} of {} matches are inliers: something moves, or the map is wrong there",
                              tracked.inliers, tracked.matches);
}

void Tracking::report_submap(int submap, SlamUpdate& update) const {
  if (submap == 0) return;
  if (update.state == SlamState::tracking) update.state = SlamState::weak;
  update.covariance.reset();
  update.reason = SlamReason::apart;
  update.detail = fmt::format("in submap {}, not connected to the first yet", submap);
}

void Tracking::insert_keyframe(const Measurements& measured, const TrackingResult& tracked, SlamUpdate& update) {
  keyframes_.count_observations(tracked);
  if (!session_.mapping) {
    follow_reference(tracked);
  } else if (keyframes_.needs_keyframe(*measured.features, tracked)) {
    const std::int64_t id = session_.next_keyframe;
    note_uncertainty(id, tracked, update.world_from_body.translation());
    // Landmarks of a keyframe get their numbers beside tracking; a feature may have been an outlier of another one.
    for (const std::uint32_t feature : keyframes_.insert(measured.features, tracked, update, measured.view)) {
      observations_[feature].landmark = -1;
      observations_[feature].state = ObservationState::new_landmark;
    }
  }
}

/// What bundle adjustment will leave of the new keyframe's errors.
void Tracking::note_uncertainty(std::int64_t keyframe, const TrackingResult& tracked, const Eigen::Vector3d& position) {
  const Matrix6d covariance = in_world_axes(tracked.covariance, tracked.camera_from_world);
  Matrix6d left = Matrix6d::Identity();
  left.topLeftCorner<3, 3>() *= session_.options.position_drift_factor;
  left.bottomRightCorner<3, 3>() *= session_.options.adjusted_rotation_share;
  session_.uncertainty.add(keyframe, tracked.reference, position, left * covariance * left,
                           session_.mono() ? scale_variance(covariance, position) : 0.0);
}

/// One camera knows the scale of new landmarks as well as the map's extent: from its start as little as its first step.
double Tracking::scale_variance(const Matrix6d& covariance, const Eigen::Vector3d& position) {
  map_extent_ = std::max(map_extent_, position.norm());
  const double drift = session_.options.scale_drift_share;
  const double of_extent = covariance.topLeftCorner<3, 3>().trace() / std::max(1e-12, map_extent_ * map_extent_);
  return drift * drift + std::min(1.0, of_extent);
}

/// States of the matches that fit the pose, and of those that do not.
void Tracking::observe(const TrackingResult& tracked, ObservationState fitting, ObservationState contradicted) {
  for (const TrackedPoint& point : tracked.outliers) {
    observations_[point.feature].landmark = point.landmark;
    observations_[point.feature].state = contradicted;
  }
  for (const TrackedPoint& point : tracked.points) {
    observations_[point.feature].landmark = point.landmark;
    observations_[point.feature].state = fitting;
  }
}

/// Landmarks of the map just initialized with the frame.
void Tracking::observe_first_landmarks(const FeatureFrame& frame) {
  const std::vector<std::int64_t> ids = session_.graph.keyframe_ids();
  for (auto id = ids.rbegin(); id != ids.rend(); ++id) {
    const MapKeyframe& keyframe = session_.graph.keyframe(*id);
    if (keyframe.frame->data().frame != frame.data().frame) continue;
    for (std::size_t i = 0; i < keyframe.landmarks.size(); ++i) {
      if (keyframe.landmarks[i] < 0) continue;
      observations_[i].landmark = keyframe.landmarks[i];
      observations_[i].state = ObservationState::new_landmark;
    }
    return;
  }
}

/// Without mapping, the view follows the camera.
void Tracking::follow_reference(const TrackingResult& tracked) {
  keyframes_.forget_observations();
  if (tracked.reference != tracker_.view()->center)
    tracker_.set_view(view_of(session_.graph, tracked.reference, session_.view_options()));
}

}  // namespace rastro
