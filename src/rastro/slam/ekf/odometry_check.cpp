// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/odometry_check.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <numbers>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr double bound_m = 0.02, bound_deg = 2.0;  // The paper's, per meter and per 45 degrees.
constexpr double segment_m = 1.0, segment_rad = std::numbers::pi / 4.0;
constexpr double degrees = 180.0 / std::numbers::pi;

}  // namespace

std::optional<SE2> OdometryCheck::finished(Segment& segment, double length, double motion, const Pose& now, bool seen) {
  segment.length += motion;
  if (!seen || (segment.start && segment.length < length)) return std::nullopt;
  const std::optional<Pose> start = segment.start;
  segment.start = now;
  // Errors accumulate differently over a much longer segment than over many short ones.
  if (!start || segment.length > 2.0 * length) {
    segment.length = 0.0;
    return std::nullopt;
  }
  const SE2 by_odometry = start->odometry_from_body.inverse() * now.odometry_from_body;
  const SE2 by_filter = start->world_from_body.inverse() * now.world_from_body;
  return by_filter.inverse() * by_odometry;
}

void OdometryCheck::add(const SE2& odometry_from_body, const SE2& world_from_body, bool seen) {
  const Pose now{odometry_from_body, world_from_body};
  if (!last_odometry_) path_.start = rotation_.start = std::nullopt;
  const SE2 motion = last_odometry_ ? last_odometry_->inverse() * odometry_from_body : SE2();
  last_odometry_ = odometry_from_body;
  if (const auto error = finished(path_, segment_m, motion.translation().norm(), now, seen)) {
    path_.errors.push_back(error->translation().norm() / path_.length);
    path_.length = 0.0;
  }
  if (const auto error = finished(rotation_, segment_rad, std::abs(motion.rotation().angle()), now, seen)) {
    rotation_.errors.push_back(std::abs(error->rotation().angle()) * segment_rad / rotation_.length);
    rotation_.length = 0.0;
  }
}

OdometryCheck::Result OdometryCheck::result() const {
  return {static_cast<int>(path_.errors.size()), upper_median_or(path_.errors, 0.0),
          static_cast<int>(rotation_.errors.size()), degrees * upper_median_or(rotation_.errors, 0.0)};
}

std::string describe(const OdometryCheck::Result& result) {
  const bool kept = result.error_m < bound_m && result.error_deg < bound_deg;
  return fmt::format(
      "odometry differs from the filter by {:.1f} cm per meter (median of {}) and {:.1f} deg per rotation of 45 deg "
      "(median of {}); "
      "{} the bound of {:.0f} cm and {:.0f} deg{}",
      100.0 * result.error_m, result.meters, result.error_deg, result.rotations, kept ? "within" : "beyond",
      100.0 * bound_m, bound_deg,
      kept
          ? ""
          : ": poses may be further off than their ellipses say; set odometry_error_m_per_m and "
            "odometry_error_deg_per_45_deg to what the robot has, or use the method hector, which matches whole scans");
}

}  // namespace rastro
