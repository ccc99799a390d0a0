// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/delayed_depth.h"

#include <cmath>

namespace rastro {
namespace {

constexpr double most_depth_offset_s = 0.1;
constexpr double delay_step_s = 0.005;

}  // namespace

SE3 DelayedDepth::depth_from_color(const Frame& frame, const Vector6d& velocity, double later_s) const {
  const double offset = to_seconds(frame.depth_stamp - frame.stamp) + delay_.seconds() + later_s;
  if (std::abs(offset) > most_depth_offset_s) return {};
  return SE3::exp(-offset * velocity);
}

std::optional<DepthReading> DelayedDepth::read(const Frame& frame, const Eigen::Vector2d& ray,
                                               const Vector6d& velocity) const {
  auto reading = read_depth(frame.depth, camera_, ray, depth_from_color(frame, velocity), options_);
  if (!reading || !options_.learn_delay) return reading;
  const auto later = read_depth(frame.depth, camera_, ray, depth_from_color(frame, velocity, delay_step_s), options_);
  if (later) reading->per_second = (later->inverse_depth - reading->inverse_depth) / delay_step_s;
  return reading;
}

}  // namespace rastro
