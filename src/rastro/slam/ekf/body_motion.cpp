// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/body_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/slam/ekf/mark_weak.h"

namespace rastro {
namespace {

constexpr double degrees_per_radian = 180.0 / std::numbers::pi;

bool has_odometry(const Frame& frame) {
  return frame.odometry_from_body && frame.odometry_from_body->translation().allFinite() &&
         std::isfinite(frame.odometry_from_body->rotation().angle());
}

std::string text_of(const SE2& motion) {
  return fmt::format("{:.3g} m and {:.0f} deg", motion.translation().norm(),
                     motion.rotation().angle() * degrees_per_radian);
}

}  // namespace

Motion BodyMotion::since_last(const Frame& frame, SlamUpdate& update) {
  frozen_.add(frame);
  if (!stamp_ || frozen_.frozen()) return {};
  const double seconds = to_seconds(frame.stamp - *stamp_);
  const bool told = has_odometry(frame);
  if (told && odometry_) return by_odometry(odometry_->inverse() * *frame.odometry_from_body, seconds, update);
  mark_weak(update, SlamReason::no_odometry,
            told ? "the previous frame had none; constant motion is assumed" : "constant motion is assumed");
  return carried(seconds);
}

void BodyMotion::begin_at(TimeNs stamp) {
  stamp_ = stamp;
  frozen_.begin_at(stamp);
}

Motion BodyMotion::by_odometry(const SE2& last_from_body, double seconds, SlamUpdate& update) {
  const auto& thaw = frozen_.thaw();
  const bool jump = is_jump(last_from_body, seconds, options_);
  if (thaw && (jump || thaw->frozen) && !is_jump(last_from_body, thaw->seconds, options_))
    return after_frozen(last_from_body, update);
  if (jump) {
    mark_weak(update, SlamReason::odometry_jumped,
              fmt::format("{} in {:.3g} s; constant motion is assumed", text_of(last_from_body), seconds));
    check_.interrupt();
    return carried(seconds);
  }
  motion_ = last_from_body;
  seconds_ = seconds;
  unknown_s_ = 0.0;
  Motion motion = measured_motion(last_from_body, options_);
  motion.covariance += not_told_;
  return motion;
}

/// Odometry that was frozen: its first step is of the whole time, of which landmarks may have told a part.
Motion BodyMotion::after_frozen(const SE2& last_from_body, SlamUpdate& update) {
  constexpr double sigma_share = 0.1;
  const FrozenOdometry::Thaw& thaw = *frozen_.thaw();
  mark_weak(update, SlamReason::odometry_jumped,
            fmt::format("{} at once after {:.3g} s in which odometry stayed the same: believed, as no landmark tells "
                        "otherwise",
                        text_of(last_from_body), thaw.seconds));
  check_.interrupt();
  unknown_s_ = 0.0;
  Motion motion = measured_motion(SE2::exp(thaw.share * last_from_body.log()), options_);
  const double distance = last_from_body.translation().norm(), angle = last_from_body.rotation().angle();
  motion.covariance.diagonal() += (sigma_share * Eigen::Vector3d(distance, distance, angle)).cwiseAbs2();
  return motion;
}

Motion BodyMotion::carried(double seconds) {
  const double before = unknown_s_;
  unknown_s_ += std::min(seconds, longest_pause_s);
  return carried_motion(motion_, seconds_, seconds, options_, before);
}

bool BodyMotion::is_frozen(std::span<const LandmarkAssociation> associations, SlamUpdate& update) {
  if (!frozen_.frozen()) frozen_.judge(associations);
  if (!frozen_.frozen()) return false;
  mark_weak(update, SlamReason::no_odometry, "odometry stays the same to the last bit while the body moves; not used");
  check_.interrupt();
  return true;
}

double BodyMotion::unknown_until() const { return std::min(frozen_.unknown_seconds(), longest_pause_s); }

Motion BodyMotion::unknown() {
  const Motion motion{SE2(), unknown_covariance()};
  unknown_s_ = std::max(unknown_s_, unknown_until());
  return motion;
}

Eigen::Matrix3d BodyMotion::unknown_covariance() const {
  if (!frozen_.frozen()) return Eigen::Matrix3d::Zero();
  return rastro::unknown_covariance(unknown_s_, unknown_until(), options_);
}

void BodyMotion::end_frame(const Frame& frame, std::span<const LandmarkAssociation> associations,
                           const SE2& world_from_body, bool corrected) {
  frozen_.end_frame(associations);
  if (frozen_.recognized()) unknown_s_ = 0.0;
  not_told_ = unknown_covariance();
  stamp_ = frame.stamp;
  odometry_ = has_odometry(frame) ? frame.odometry_from_body : std::nullopt;
  if (odometry_) {
    check_.add(*odometry_, world_from_body, corrected);
  } else {
    check_.interrupt();
  }
}

}  // namespace rastro
