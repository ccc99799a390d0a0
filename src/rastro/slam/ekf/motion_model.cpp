// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/motion_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace rastro {
namespace {

constexpr double radians_per_degree = std::numbers::pi / 180.0;

double square(double value) { return value * value; }

}  // namespace

Motion measured_motion(const SE2& last_from_body, const EkfOptions& options) {
  const double distance = last_from_body.translation().norm();
  const double rotation = std::abs(last_from_body.rotation().angle());
  const double along = square(options.odometry_error_m_per_m) * distance;
  const double angle =
      square(options.odometry_error_deg_per_45_deg * radians_per_degree) * rotation / (45.0 * radians_per_degree) +
      square(options.heading_error_deg_per_m * radians_per_degree) * distance;
  return {last_from_body, Eigen::Vector3d(along, along, angle).asDiagonal(), true};
}

Motion carried_motion(const SE2& last_motion, double last_seconds, double seconds, const EkfOptions& options,
                      double unknown_seconds) {
  // Limited to a few times the last step: the robot may have stopped during a pause.
  const double share = last_seconds > 0.0 ? std::clamp(seconds / last_seconds, 0.0, 5.0) : 0.0;
  const double until = unknown_seconds + std::min(seconds, longest_pause_s);
  return {SE2::exp(share * last_motion.log()), unknown_covariance(unknown_seconds, until, options)};
}

Eigen::Matrix3d unknown_covariance(double from_seconds, double to_seconds, const EkfOptions& options) {
  constexpr double lasting_s = 10.0, all_round_rad2 = 4.0;
  const auto variance = [&](double rate, double seconds) {
    return square(rate) * seconds * std::min(seconds, lasting_s);
  };
  const auto gained = [&](double rate, double most) {
    const double before = std::min(variance(rate, from_seconds), most);
    return std::max(0.0, std::min(variance(rate, to_seconds), most) - before);
  };
  const double position = gained(options.unknown_speed_m_per_s, std::numeric_limits<double>::infinity());
  const double angle = gained(options.unknown_yaw_rate_deg_per_s * radians_per_degree, all_round_rad2);
  return Eigen::Vector3d(position, position, angle).asDiagonal();
}

bool is_jump(const SE2& last_from_body, double seconds, const EkfOptions& options) {
  const double distance = last_from_body.translation().norm();
  const double rotation = std::abs(last_from_body.rotation().angle());
  const bool plausible = distance <= options.max_speed_m_per_s * seconds + options.jump_m &&
                         rotation <= (options.max_yaw_rate_deg_per_s * seconds + options.jump_deg) * radians_per_degree;
  return !plausible;
}

}  // namespace rastro
