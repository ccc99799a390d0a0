// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/profiles/profiles_odometry.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "rastro/track/stopwatch.h"

namespace rastro {

ProfilesOdometry::ProfilesOdometry(const ProfilesOptions& options, const Camera& camera)
    : options_(options), check_(options.check), meter_(options.turn, camera) {}

OdometryUpdate ProfilesOdometry::process(const Frame& frame) {
  Stopwatch watch;
  OdometryUpdate update;
  update.index = frame.index;
  update.stamp = frame.stamp;
  const FrameCheckResult check = check_.check(frame.image, frame.stamp);
  update.reason = check.reason;
  update.detail = check.detail;
  if (!check.useful()) {
    bridge(update);
  } else if (const auto turn = meter_.look(frame.image)) {
    follow(*turn, update);
  } else {
    update.reason = OdometryReason::first_frame;
    update.state = OdometryState::tracking;
    meter_.keep_as_reference();
  }
  update.world_from_camera = world_from_current_;
  trajectory_.push_back({frame.stamp, world_from_current_});
  update.milliseconds = watch.lap_ms();
  return update;
}

void ProfilesOdometry::bridge(OdometryUpdate& update) {
  update.used = false;
  update.confidence = 0.0;
  update.state = OdometryState::weak;
  if (update.reason == OdometryReason::repeated_frame) return;
  if (++bridged_ > options_.max_bridged_frames) {
    update.state = OdometryState::lost;
    return;
  }
  world_from_current_ = world_from_current_ * motion_of(last_turn_, 1);
}

void ProfilesOdometry::follow(const Turn& turn, OdometryUpdate& update) {
  update.confidence = turn.columns.confidence;
  update.state = OdometryState::tracking;
  const int frames = bridged_ + 1;
  if (turn.still) {
    // The reference stays, so that a creeping motion is not lost piece by piece.
    update.reason = OdometryReason::no_motion;
    world_from_current_ = world_from_reference_;
    last_turn_ = SO3();
    last_yaw_ = 0.0;
    bridged_ = 0;
    return;
  }
  double yaw = turn.yaw, pitch = turn.pitch;
  const double change_deg = std::abs(yaw / frames - last_yaw_) * 180.0 / std::numbers::pi;
  if (turn.weak || update.reason == OdometryReason::gap) {
    update.state = OdometryState::weak;
    if (update.reason == OdometryReason::none) {
      update.reason = OdometryReason::few_inliers;
      update.detail = fmt::format("confidence {:.2f}, need {:.2f}", update.confidence, options_.turn.min_confidence);
    }
    if (turn.weak && change_deg > options_.turn.max_turn_change_deg) {
      yaw = last_yaw_ * frames;
      pitch = 0.0;
    }
  }
  world_from_current_ = world_from_reference_ * motion_of(rotation_of(yaw, pitch), frames);
  last_yaw_ = yaw / frames;
  last_turn_ = rotation_of(last_yaw_, pitch / frames);
  world_from_reference_ = world_from_current_;
  bridged_ = 0;
  meter_.keep_as_reference();
}

SE3 ProfilesOdometry::motion_of(const SO3& rotation, int frames) const {
  const SO3 halfway = SO3::exp(0.5 * rotation.log());
  return {rotation, halfway * Eigen::Vector3d(0.0, 0.0, options_.forward_step * frames)};
}

}  // namespace rastro
