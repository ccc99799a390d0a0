// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/rgbd_session.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <utility>

#include "rastro/backend/rgbd/edge_covariance.h"
#include "rastro/backend/rgbd/frame_report.h"
#include "rastro/backend/rgbd/given_map.h"
#include "rastro/backend/rgbd/global_shutter.h"
#include "rastro/base/checked_options.h"
#include "rastro/base/stopwatch.h"

namespace rastro {

RgbdSession::RgbdSession(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context)
    : RgbdSession(options, camera, context, Method()) {}

RgbdSession::RgbdSession(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context,
                         Method method)
    : options_(checked(options, "rgbd options")),
      camera_(camera),
      maps_(!context.map || context.extend_map),
      on_finishing_(context.on_finishing),
      mapper_(options_, camera, context, std::move(method.search)),
      map_(context.map ? *context.map : base_map(method.name, options_, camera, method.baseline), mapper_.images(),
           !maps_, mapper_.signatures()),
      relocalizer_(options_, camera, mapper_.depths(), mapper_.appearances()),
      follower_(options_.follow, camera, context.pool),
      safe_{.archive = maps_ ? context.archive : nullptr},
      following_{.has_pose = maps_,
                 .motion_check = MotionCheck(options_.max_acceleration),
                 .appearance = TrackedAppearance(mapper_.appearances().check())},
      loss_{.lost = !maps_},
      hint_(context.initial_pose),
      mapping_state_(mapper_.state()),
      pipeline_(mapping_pipeline(context.pipelined, context.live, context.pool)) {}

SlamUpdate RgbdSession::process(const Frame& frame) {
  Stopwatch whole, stage;
  SlamUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  ++counts_.seen;
  following_.has_last_frame = false;
  update.events = std::exchange(events_, {});
  const std::size_t keyframes = map_.keyframes().size();
  while (auto mapped = pipeline_.take_ready({counts_.seen, frame.stamp})) apply(std::move(*mapped), update.events);
  const bool has_grown = map_.keyframes().size() > keyframes;
  update.times.push_back({"wait", stage.lap_ms()});
  update.world_from_body = last_pose_;
  follow(frame, update);
  if (corrects_map(update.events)) following_.motion_check.forget();
  following_.motion_check.check(update);
  last_pose_ = update.world_from_body;
  keep_safe(has_grown);
  update.milliseconds = whole.lap_ms();
  return update;
}

/// A new keyframe at once, so that a killed run loses hardly more than that; but a large map is not copied for each.
void RgbdSession::keep_safe(bool has_grown) {
  constexpr double most_share = 0.05;  // of the time
  if (safe_.archive == nullptr) return;
  const bool affordable = safe_.snapshot_ms <= most_share * safe_.since.elapsed_ms();
  if (!(has_grown && affordable) && !safe_.archive->wants_map()) return;
  Stopwatch watch;
  safe_.archive->keep(map_.snapshot());
  safe_.snapshot_ms = watch.lap_ms();
  safe_.since = Stopwatch();
}

void RgbdSession::follow(const Frame& frame, SlamUpdate& update) {
  Stopwatch stage;
  if (!following_.has_pose) {
    update.state = exists() || !maps_ ? SlamState::lost : SlamState::initializing;
    update.reason = SlamReason::not_found;
    relocalize(frame, update);
    update.times.push_back({"relocalize", stage.lap_ms()});
    return;
  }
  RgbdFollow followed = follower_.follow(frame);
  following_.has_last_frame = true;
  doubt(frame, followed);
  update.times.push_back({"follow", stage.lap_ms()});
  update.reason = reason_of(followed.reason);
  update.detail = followed.detail;
  update.world_from_body = followed.world_from_camera;
  const bool nothing_new =
      followed.reason == OdometryReason::dark_or_blank || followed.reason == OdometryReason::repeated_frame;
  if (followed.state == OdometryState::initializing) {
    update.state = SlamState::initializing;
  } else if (followed.reason == OdometryReason::repeated_frame && !loss_.lost && exists()) {
    update.state = SlamState::weak;
    map_.add_frame(frame.stamp, anchor_.keyframe, anchor_.world_from_keyframe.inverse() * followed.world_from_camera);
  } else if (followed.state == OdometryState::lost || nothing_new || is_doubtful_return(followed, update)) {
    update.state = SlamState::lost;
    on_loss(frame, update);
    update.times.push_back({"relocalize", stage.lap_ms()});
  } else {
    on_pose(frame, followed, update);
    update.times.push_back({"keyframe", stage.lap_ms()});
  }
}

/// The pose stays the best guess, but neither it nor the constraint that it gives is to be trusted.
void RgbdSession::doubt(const Frame& frame, RgbdFollow& followed) {
  following_.doubtful = false;
  const bool has_pose = followed.state == OdometryState::tracking || followed.state == OdometryState::weak;
  if (!has_pose || !exists()) return;
  const SE3 keyframe_from_camera = anchor_.world_from_keyframe.inverse() * followed.world_from_camera;
  const auto contradiction = following_.appearance.contradiction(frame, keyframe_from_camera);
  if (!contradiction) return;
  following_.doubtful = true;
  followed.state = OdometryState::weak;
  followed.reason = OdometryReason::few_inliers;
  followed.detail =
      fmt::format("{} of {} patches look different from keyframe {}: it may be somewhere else that fits",
                  contradiction->contradict, contradiction->agree + contradiction->contradict, anchor_.keyframe);
  followed.covariance += look_alike_covariance();
}

/// Surfaces alone fit anywhere: a camera that was lost for long is looked for in the map.
bool RgbdSession::is_doubtful_return(const RgbdFollow& followed, SlamUpdate& update) {
  if (!loss_.lost || just_lost() || !exists() || followed.reason != OdometryReason::too_few_points) return false;
  following_.has_pose = false;
  update.world_from_body = last_pose_;
  return true;
}

void RgbdSession::on_pose(const Frame& frame, const RgbdFollow& followed, SlamUpdate& update) {
  update.state = followed.state == OdometryState::weak ? SlamState::weak : SlamState::tracking;
  if (loss_.lost) update.state = SlamState::relocalized;
  loss_.lost = false;
  loss_.frames = 0;
  update.score = followed.points > 0 ? followed.inlier_share : 1.0;
  update.used = followed.inliers + followed.surface_points;
  const SE3& pose = followed.world_from_camera;
  following_.motion.note(frame.stamp, pose);
  following_.appearance.note(frame.stamp);
  if (!exists()) {
    make_keyframe(frame, pose, std::nullopt, update);
  } else {
    mapping_ ? update_pose(frame, followed, update) : localize(frame, followed, update);
    map_.add_frame(frame.stamp, anchor_.keyframe, anchor_.world_from_keyframe.inverse() * update.world_from_body);
    return;
  }
  map_.add_frame(frame.stamp, anchor_.keyframe, SE3());
}

Matrix6d RgbdSession::covariance_of(const SE3& pose, const Matrix6d& from_keyframe) const {
  const SE3 keyframe_from_camera = anchor_.world_from_keyframe.inverse() * pose;
  const Matrix6d sum =
      chained(anchor_.covariance, keyframe_from_camera, mapping_state_.variance_factor * from_keyframe);
  const bool is_first = anchor_.covariance.isZero(0.0);  // what poses count from
  return is_first ? sum : with_common_errors(sum, options_);
}

/// Where the follower has the frame, which becomes a keyframe where it is to.
void RgbdSession::update_pose(const Frame& frame, const RgbdFollow& followed, SlamUpdate& update) {
  const SE3& pose = followed.world_from_camera;
  const Matrix6d from_keyframe =
      chained(anchor_.reference_covariance, anchor_.world_from_reference.inverse() * pose, followed.covariance);
  if (needs_keyframe(followed) && pipeline_.accepts()) {
    if (!revisit(frame, pose, from_keyframe, update))
      make_keyframe(frame, pose, path_edge(pose, from_keyframe), update);
    return;
  }
  if (followed.new_reference) {
    anchor_.world_from_reference = pose;
    anchor_.reference_covariance = from_keyframe;
  }
  say_pose(pose, covariance_of(pose, from_keyframe), update);
}

bool RgbdSession::has_moved(const RgbdFollow& followed) const {
  const SE3 moved = anchor_.world_from_keyframe.inverse() * followed.world_from_camera;
  return moved.translation().norm() >= mapping_state_.spacing * options_.keyframe_distance_m ||
         moved.rotation().log().norm() >= mapping_state_.spacing * options_.keyframe_angle_rad ||
         static_cast<double>(counts_.seen - counts_.anchored) >= mapping_state_.spacing * options_.keyframe_frames;
}

/// Where memory is short, not every frame that the follower refers others to. What is doubtful is so from one keyframe
/// on, as long as the map does not know better.
bool RgbdSession::needs_keyframe(const RgbdFollow& followed) const {
  if (following_.doubtful) return true;
  return (followed.new_reference && mapping_state_.spacing <= 1.0) || has_moved(followed);
}

Constraint RgbdSession::path_edge(const SE3& world_from_camera, const Matrix6d& covariance) const {
  Constraint edge;
  edge.from = anchor_.keyframe;
  edge.to = map_.keyframe_count();
  edge.from_from_to = Sim3(anchor_.world_from_keyframe.inverse() * world_from_camera);
  edge.information = information_of(with_common_errors(covariance, options_));
  edge.kind = ConstraintKind::odometry;
  return edge;
}

/// Relative to the keyframe of the constraint; without one it begins a submap.
void RgbdSession::make_keyframe(const Frame& frame, const SE3& world_from_camera,
                                const std::optional<Constraint>& constraint, SlamUpdate& update) {
  const std::int64_t id = map_.keyframe_count(), from = constraint ? constraint->from : -1;
  const int submap = constraint ? map_.submap(from) : map_.new_submap();
  const auto order = std::make_shared<KeyframeOrder>(
      KeyframeOrder{id, kept_of(frame), world_from_camera, submap, constraint, map_.frame_count()});
  map_.add_pending({world_from_camera, submap}, from,
                   constraint ? Matrix6d(mapping_state_.variance_factor * without_common_errors(*constraint, options_))
                              : Matrix6d(Matrix6d::Zero()));
  anchor_ = {id, world_from_camera, map_.covariance(id), world_from_camera, Matrix6d::Zero()};
  following_.appearance.keep(frame);
  counts_.anchored = counts_.seen;
  update.events.push_back({"keyframe", fmt::format("{}", id)});
  say_pose(world_from_camera, covariance_of(world_from_camera, Matrix6d::Zero()), update);
  const auto job = [this, order, rotation = Eigen::Vector3d(following_.motion.velocity().tail<3>()),
                    segment = segment_] {
    order->frame = by_global_shutter(std::move(order->frame), camera_, rotation);
    return MappedKeyframe{order->id, segment, mapper_.add(*order)};
  };
  pipeline_.submit(job, {counts_.seen, frame.stamp}, {.frames = options_.backend_delay_frames});
}

void RgbdSession::say_pose(const SE3& world_from_camera, const Matrix6d& covariance, SlamUpdate& update) {
  update.world_from_body = world_from_camera;
  update.covariance = in_world_axes(covariance, world_from_camera);
  const int submap = map_.submap(anchor_.keyframe);
  if (submap == 0) return;
  if (update.state == SlamState::tracking) update.state = SlamState::weak;
  update.covariance.reset();
  update.reason = SlamReason::apart;
  update.detail = fmt::format("in submap {}, not connected to the first yet: its position is a guess", submap);
}

/// The follower goes on from where the graph put its keyframe.
void RgbdSession::apply(MappedKeyframe mapped, std::vector<SlamEvent>& events) {
  events.insert(events.end(), mapped.revision.events.begin(), mapped.revision.events.end());
  mapping_state_ = mapped.revision.state;
  const SE3 before = map_.pose(mapped.keyframe);
  map_.apply(std::move(mapped.revision));
  if (mapped.segment != segment_) return;
  const SE3 correction = map_.pose(mapped.keyframe) * before.inverse();
  map_.move_pending(mapped.keyframe + 1, correction, map_.submap(mapped.keyframe));
  anchor_.covariance = map_.covariance(anchor_.keyframe);
  constexpr double least = 1e-9;
  if (!(correction.log().norm() > least)) return;
  move(correction);
  if (mapped.keyframe != anchor_.keyframe)
    anchor_.world_from_keyframe = correction * anchor_.world_from_keyframe;
  else
    anchor_.world_from_keyframe = map_.pose(mapped.keyframe);
  anchor_.world_from_reference = correction * anchor_.world_from_reference;
  last_pose_ = correction * last_pose_;
}

/// To be matched with keyframes.
Frame RgbdSession::as_keyframe(const Frame& frame) const {
  return by_global_shutter(frame, camera_, following_.motion.velocity().tail<3>());
}

/// What the session knows of the frames before moves with the map.
void RgbdSession::move(const SE3& new_world_from_world) {
  follower_.move(new_world_from_world);
  following_.motion.move(new_world_from_world);
}

/// A map given stays as it is.
bool RgbdSession::set_mapping(bool on) {
  if (!maps_ || (!on && !exists())) return false;
  while (auto mapped = pipeline_.take_next()) apply(std::move(*mapped), events_);
  mapping_ = on;
  return true;
}

std::vector<FeatureObservation> RgbdSession::observations() const {
  std::vector<FeatureObservation> observations;
  if (!following_.has_last_frame) return observations;
  for (const FollowedFeature& feature : follower_.features())
    observations.push_back({feature.pixel, -1, state_of(feature.state)});
  return observations;
}

std::vector<SlamEvent> RgbdSession::finish() {
  std::vector<SlamEvent> events;
  while (auto mapped = pipeline_.take_next()) apply(std::move(*mapped), events);
  if (!maps_ || !mapping_) return events;
  if (on_finishing_) on_finishing_("last optimization of the graph", 0, 1);
  MapRevision revision = mapper_.settle();  // no job is under way any more
  mapping_state_ = revision.state;
  events.insert(events.end(), revision.events.begin(), revision.events.end());
  map_.apply(std::move(revision));
  if (map_.make_largest_first()) events.push_back({"submap", "the largest is now the first"});
  if (const int shown = map_.trajectory_submap(); shown != 0)
    events.push_back(
        {"submap", fmt::format("{} is not connected to the first: the trajectory is in its frame", shown)});
  return events;
}

}  // namespace rastro
