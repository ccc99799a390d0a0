// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>

#include "rastro/backend/rgbd/frame_report.h"
#include "rastro/backend/rgbd/rgbd_session.h"

namespace rastro {

/// The follower drifts: where a keyframe would be made, the frame is held against the map's around it instead.
void RgbdSession::localize(const Frame& frame, const RgbdFollow& followed, SlamUpdate& update) {
  SE3 pose = followed.world_from_camera;
  Matrix6d from_keyframe =
      chained(anchor_.reference_covariance, anchor_.world_from_reference.inverse() * pose, followed.covariance);
  if (followed.new_reference) {
    anchor_.world_from_reference = pose;
    anchor_.reference_covariance = from_keyframe;
  }
  const bool due = counts_.seen - counts_.localized >= options_.relocalize_every && !frame.depth.empty();
  if (due && (followed.new_reference || has_moved(followed))) {
    counts_.localized = counts_.seen;
    const auto seed = seed_for(options_.follow.seed ^ 0x5EEDULL, static_cast<std::uint64_t>(counts_.seen));
    const auto found = relocalizer_.find_among(as_keyframe(frame), with_features(keyframes_near(pose)), seed);
    if (found && found->looks_alike) {
      anchor_at(found->keyframe, found->constraint);
      from_keyframe = anchor_.reference_covariance;
      move(anchor_.world_from_reference * pose.inverse());
      pose = anchor_.world_from_reference;
    }
  }
  say_pose(pose, covariance_of(pose, from_keyframe), update);
}

/// The frame stands relative to a keyframe that it was matched with.
void RgbdSession::anchor_at(std::int64_t keyframe, const KeyframeConstraint& constraint) {
  const SE3 world_from_keyframe = map_.pose(keyframe);
  anchor_ = {keyframe, world_from_keyframe, map_.covariance(keyframe), world_from_keyframe * constraint.a_from_b,
             constraint.information.inverse()};
  following_.appearance.forget();
  counts_.anchored = counts_.seen;
}

void RgbdSession::on_loss(const Frame& frame, SlamUpdate& update) {
  if (!loss_.lost) loss_.frames = 0, loss_.since = frame.stamp;
  loss_.lost = true;
  following_.motion.restart(update.world_from_body);
  if (update.reason == SlamReason::dark_or_blank || update.reason == SlamReason::repeated_frame) return;
  relocalize(frame, update);
}

/// For the map first; ground that was not found again long enough is taken for new.
void RgbdSession::relocalize(const Frame& frame, SlamUpdate& update) {
  if (frame.image.empty() || frame.depth.empty()) {
    if (update.reason == SlamReason::not_found || update.reason == SlamReason::none)
      update.reason = SlamReason::no_data;
    return;
  }
  // A frame that is found becomes a keyframe in any case: mapping must not refuse it.
  while (mapping_ && !pipeline_.has_room()) apply(std::move(*pipeline_.take_next()), update.events);
  ++loss_.frames;
  if (!loss_.unconfirmed.empty() || just_lost() || (loss_.frames - 1) % options_.relocalize_every == 0) {
    const auto found = find_in_map(frame, update);
    if (found && confirm(frame, *found, update)) return on_relocalized(frame, *found, update);
    if (found) return;
    loss_.unconfirmed.clear();
  }
  const bool long_lost =
      loss_.frames >= options_.lost_frames || to_seconds(frame.stamp - loss_.since) >= options_.lost_s;
  if (maps_ && mapping_ && exists() && long_lost) {
    const SE3 guess = update.world_from_body;
    if (start_again(frame, guess, std::nullopt, update))
      update.events.push_back({"submap", fmt::format("{} started, no relocalization in {} frames",
                                                     map_.submap(anchor_.keyframe), loss_.frames)});
  }
}

/// Where the frames before were found first, else near the initial pose.
std::optional<Relocalizer::Found> RgbdSession::find_in_map(const Frame& frame, SlamUpdate& update) {
  const auto seed = seed_for(options_.follow.seed ^ 0x5EEDULL, static_cast<std::uint64_t>(counts_.seen));
  Relocalizer::First first;
  first.ids = loss_.unconfirmed.empty() ? hinted_keyframes() : std::vector{loss_.unconfirmed.back().keyframe};
  if (mapper_.recognizes_places()) {
    while (auto mapped = pipeline_.take_next()) apply(std::move(*mapped), update.events);  // the search is mapping's
    first.similar = [this](const ImageFeatures& seen) { return mapper_.similar(seen); };
  }
  const Relocalizer::Try tried = relocalizer_.find(frame, map_.keyframes(), seed, first);
  if (update.detail.empty())
    update.detail = fmt::format("{} features, matched with none of {} keyframes", tried.features, tried.compared);
  return tried.found;
}

/// One place may look like another: several frames in a row must be found in the same one. One is enough where the
/// camera was lost a moment ago and has hardly moved since.
bool RgbdSession::confirm(const Frame& frame, const Relocalizer::Found& found, SlamUpdate& update) {
  const SE3 pose = map_.pose(found.keyframe) * found.constraint.a_from_b;
  if (!agrees_with_last(frame.stamp, pose)) loss_.unconfirmed.clear();
  const std::size_t agreeing = loss_.unconfirmed.size() + 1;
  const bool enough = agreeing >= static_cast<std::size_t>(options_.relocalize_frames);
  if ((enough && found.looks_alike) || continues_motion(pose)) return true;
  loss_.unconfirmed.push_back({frame.stamp, found.keyframe, found.constraint.a_from_b});
  update.reason = SlamReason::unconfirmed;
  update.detail = fmt::format("in keyframe {} with {} inliers of {} matches; {} of {} frames agree{}", found.keyframe,
                              found.constraint.inliers, found.constraint.matches, agreeing, options_.relocalize_frames,
                              found.looks_alike ? "" : ", but it looks different");
  return false;
}

bool RgbdSession::agrees_with_last(TimeNs stamp, const SE3& world_from_camera) const {
  constexpr double least_m = 0.3, least_rad = 0.35, meters_per_s = 2.0, rad_per_s = 1.5;
  if (loss_.unconfirmed.empty()) return true;
  const UnconfirmedFrame& last = loss_.unconfirmed.back();
  const double seconds = to_seconds(stamp - last.stamp);
  const double max_distance_m = std::max(least_m, meters_per_s * seconds),
               max_angle_rad = std::max(least_rad, rad_per_s * seconds);
  const SE3 moved = (map_.pose(last.keyframe) * last.keyframe_from_camera).inverse() * world_from_camera;
  return moved.translation().norm() <= max_distance_m && moved.rotation().log().norm() <= max_angle_rad;
}

bool RgbdSession::just_lost() const {
  constexpr int most_frames = 5;
  return exists() && loss_.frames <= most_frames;
}

bool RgbdSession::continues_motion(const SE3& world_from_camera) const {
  constexpr double max_distance_m = 0.1, max_angle_rad = 0.1;  // per frame
  if (!just_lost()) return false;
  const SE3 moved = last_pose_.inverse() * world_from_camera;
  return moved.translation().norm() <= max_distance_m * loss_.frames &&
         moved.rotation().log().norm() <= max_angle_rad * loss_.frames;
}

void RgbdSession::on_relocalized(const Frame& frame, const Relocalizer::Found& found, SlamUpdate& update) {
  const std::int64_t keyframe = found.keyframe;
  const KeyframeConstraint& constraint = found.constraint;
  for (const UnconfirmedFrame& before : loss_.unconfirmed)
    map_.add_frame(before.stamp, before.keyframe, before.keyframe_from_camera);
  loss_.unconfirmed.clear();
  const Constraint edge{
      keyframe, map_.keyframe_count(), Sim3(constraint.a_from_b), constraint.information, ConstraintKind::proximity,
      1.0,      constraint.inliers};
  if (!start_again(frame, map_.pose(keyframe) * constraint.a_from_b, edge, update)) return;
  update.score = static_cast<double>(constraint.inliers) / std::max(1, constraint.matches);
  update.used = constraint.inliers;
  update.events.push_back({"relocalized",
                           fmt::format("in keyframe {} with {} inliers of {} matches after {} frames", keyframe,
                                       constraint.inliers, constraint.matches, loss_.frames),
                           keyframe});
}

std::vector<std::int64_t> RgbdSession::hinted_keyframes() const {
  if (!hint_ || maps_) return {};
  return map_.nearest(*hint_, 0, options_);
}

bool RgbdSession::start_again(const Frame& frame, const SE3& world_from_camera,
                              const std::optional<Constraint>& constraint, SlamUpdate& update) {
  follower_.restart(world_from_camera);
  following_.motion.restart(world_from_camera);
  const RgbdFollow followed = follower_.follow(frame);
  following_.has_pose = followed.new_reference;
  if (!following_.has_pose) return false;
  ++segment_;
  loss_.lost = false;
  update.state = SlamState::relocalized;
  update.reason = SlamReason::none;
  update.detail.clear();
  hint_.reset();
  following_.motion.note(frame.stamp, world_from_camera);
  following_.appearance.note(frame.stamp);
  if (!mapping_) {
    anchor_at(constraint->from, {constraint->rigid(), constraint->information, 0, constraint->inliers, {}});
    say_pose(world_from_camera, covariance_of(world_from_camera, anchor_.reference_covariance), update);
    map_.add_frame(frame.stamp, anchor_.keyframe, anchor_.world_from_keyframe.inverse() * world_from_camera);
    return true;
  }
  make_keyframe(frame, world_from_camera, constraint, update);
  map_.add_frame(frame.stamp, anchor_.keyframe, SE3());
  return true;
}

}  // namespace rastro
