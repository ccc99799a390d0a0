// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/odometry_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rastro {
namespace {

constexpr double bound_m = 0.02, bound_deg = 2.0;  // The paper's, per metre and per 45 degrees.
constexpr double stretch_m = 1.0, stretch_rad = std::numbers::pi / 4.0;
constexpr double degrees = 180.0 / std::numbers::pi;

double root_mean(double sum, int count) { return count > 0 ? std::sqrt(sum / count) : 0.0; }

}  // namespace

SE2 OdometryCheck::difference(const Pose& from, const Pose& to) {
  const SE2 by_odometry = from.odometry_from_body.inverse() * to.odometry_from_body;
  const SE2 by_filter = from.world_from_body.inverse() * to.world_from_body;
  return by_filter.inverse() * by_odometry;
}

void OdometryCheck::add(const SE2& odometry_from_body, const SE2& world_from_body) {
  const Pose now{odometry_from_body, world_from_body};
  if (!last_) {
    last_ = stretch_start_ = turn_start_ = now;
    way_ = turn_ = 0.0;
    return;
  }
  const SE2 motion = last_->odometry_from_body.inverse() * odometry_from_body;
  last_ = now;
  way_ += motion.translation().norm();
  turn_ += std::abs(motion.rotation().angle());
  if (way_ >= stretch_m) {
    // Per metre, also where one step is longer than that.
    squared_metres_ += difference(stretch_start_, now).translation().squaredNorm() / (way_ * way_);
    ++metres_;
    stretch_start_ = now;
    way_ = 0.0;
  }
  if (turn_ >= stretch_rad) {
    const double error = difference(turn_start_, now).rotation().angle() * stretch_rad / turn_;
    squared_turns_ += error * error;
    ++turns_;
    turn_start_ = now;
    turn_ = 0.0;
  }
}

OdometryCheck::Result OdometryCheck::result() const {
  return {metres_, root_mean(squared_metres_, metres_), turns_, degrees * root_mean(squared_turns_, turns_)};
}

std::string describe(const OdometryCheck::Result& result) {
  const bool kept = result.error_m < bound_m && result.error_deg < bound_deg;
  return fmt::format(
      "odometry differs from the filter by {:.1f} cm per metre over {} metres and {:.1f} deg per 45 deg over {} turns; "
      "{} the bound of {:.0f} cm and {:.0f} deg",
      100.0 * result.error_m, result.metres, result.error_deg, result.turns, kept ? "within" : "beyond",
      100.0 * bound_m, bound_deg);
}

}  // namespace rastro
