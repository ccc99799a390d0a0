// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/motion_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rastro/base/time.h"

namespace rastro {
namespace {

constexpr double longest_interval_s = 0.5;

}  // namespace

bool corrects_map(const std::vector<SlamEvent>& events) {
  return std::any_of(events.begin(), events.end(), [](const SlamEvent& event) {
    return event.kind == "loop_closed" || event.kind == "joined" || event.kind == "map_revised";
  });
}

void MotionCheck::follow(const SE3& new_from_old) {
  if (!last_) return;
  last_->position = new_from_old * last_->position;
  if (last_->velocity) last_->velocity = new_from_old.rotation() * *last_->velocity;
}

void MotionCheck::check(SlamUpdate& update) {
  const bool follows = update.state == SlamState::tracking || update.state == SlamState::weak;
  if (!follows && update.state != SlamState::relocalized) return last_.reset();
  const Eigen::Vector3d position = update.world_from_body.translation();
  const std::optional<Last> before = std::exchange(last_, Last{update.stamp, position, {}});
  if (!follows || !before) return;
  const double interval = to_seconds(update.stamp - before->stamp);
  if (!(interval > 0.0) || interval > longest_interval_s) return;
  const Eigen::Vector3d velocity = (position - before->position) / interval;
  last_->velocity = velocity;
  if (!before->velocity || max_acceleration_ == 0.0 || update.state != SlamState::tracking) return;
  const double acceleration = (velocity - *before->velocity).norm() / interval;
  if (!(acceleration > max_acceleration_)) return;
  update.state = SlamState::weak;
  update.reason = SlamReason::implausible_motion;
  update.detail = fmt::format("the pose would need an acceleration of {:.0f} m/s^2, at most {:.0f} is plausible",
                              acceleration, max_acceleration_);
}

}  // namespace rastro
