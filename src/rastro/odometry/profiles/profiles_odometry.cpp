// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/profiles/profiles_odometry.h"

#include <fmt/format.h>

#include "rastro/base/checked_options.h"
#include "rastro/base/stopwatch.h"

namespace rastro {

ProfilesOdometry::ProfilesOdometry(const ProfilesOptions& options, const Camera& camera)
    : options_(checked(options, "odometry options")), check_(options.check), rotations_(options.rotation, camera) {}

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
  } else if (const auto step = rotations_.step(frame.image, bridged_ + 1)) {
    follow(*step, update);
  } else {
    has_reference_ = true;
    update.reason = OdometryReason::first_frame;
    update.state = OdometryState::tracking;
  }
  update.world_from_camera = world_from_current_;
  trajectory_.push_back({frame.stamp, world_from_current_});
  update.milliseconds = watch.lap_ms();
  return update;
}

void ProfilesOdometry::bridge(OdometryUpdate& update) {
  update.used = false;
  update.confidence = 0.0;
  update.state = has_reference_ ? OdometryState::weak : OdometryState::initializing;
  if (!has_reference_ || update.reason == OdometryReason::repeated_frame) return;
  if (++bridged_ > options_.max_bridged_frames) {
    update.state = OdometryState::lost;
    return;
  }
  world_from_current_ = world_from_current_ * motion_of(rotations_.last_rotation(), 1);
}

void ProfilesOdometry::follow(const RotationStep& step, OdometryUpdate& update) {
  const int frames = bridged_ + 1;
  bridged_ = 0;
  update.confidence = step.measured.columns.confidence;
  update.state = OdometryState::tracking;
  if (step.measured.still) {
    update.reason = OdometryReason::no_motion;
    world_from_current_ = world_from_reference_;
    return;
  }
  if (step.measured.weak || update.reason == OdometryReason::gap) update.state = OdometryState::weak;
  if (step.measured.weak && update.reason == OdometryReason::none) {
    update.reason = OdometryReason::few_inliers;
    update.detail = fmt::format("confidence {:.2f}, need {:.2f}", update.confidence, options_.rotation.min_confidence);
  }
  world_from_current_ = world_from_reference_ * motion_of(step.reference_from_current, frames);
  world_from_reference_ = world_from_current_;
}

SE3 ProfilesOdometry::motion_of(const SO3& rotation, int frames) const {
  const SO3 halfway = SO3::exp(0.5 * rotation.log());
  return {rotation, halfway * Eigen::Vector3d(0.0, 0.0, options_.forward_step * frames)};
}

}  // namespace rastro
