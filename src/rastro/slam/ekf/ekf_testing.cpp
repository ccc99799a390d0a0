// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/ekf_testing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/slam/ekf/motion_model.h"

namespace rastro::testing {

LandmarkWorld ring_world(std::size_t landmarks, std::uint64_t seed) {
  LandmarkWorld world;
  Random random(seed);
  const Eigen::Vector2d centre(0.0, world.radius_m);
  while (world.landmarks.size() < landmarks) {
    const SO2 direction = SO2::from_angle(random.uniform(-std::numbers::pi, std::numbers::pi));
    const Eigen::Vector2d place = centre + direction * Eigen::Vector2d(world.radius_m + random.uniform(-2.5, 4.0), 0.0);
    const bool crowded = std::any_of(world.landmarks.begin(), world.landmarks.end(),
                                     [&](const Eigen::Vector2d& other) { return (other - place).norm() < 1.0; });
    if (!crowded) world.landmarks.push_back(place);
  }
  return world;
}

Frame LandmarkDrive::next() {
  Frame frame;
  if (frames_ > 0) {
    const SE2 motion = SE2::exp({world_.step_m, 0.0, world_.step_m / world_.radius_m});
    truth_ = truth_ * motion;
    odometry_ = odometry_ * noisy(motion);
  }
  frame.index = frames_;
  frame.stamp = 100'000'000 * ++frames_;
  frame.odometry_from_body = odometry_;
  see(frame);
  return frame;
}

SE2 LandmarkDrive::noisy(const SE2& motion) {
  const Eigen::Vector3d sigma =
      world_.odometry_scale * measured_motion(motion, options_).covariance.diagonal().cwiseSqrt();
  const Eigen::Vector2d translation =
      motion.translation() + Eigen::Vector2d(sigma.x() * random_.normal(), sigma.y() * random_.normal());
  return {motion.rotation() * SO2::from_angle(sigma.z() * random_.normal()), translation};
}

void LandmarkDrive::see(Frame& frame) {
  for (std::size_t i = 0; i < world_.landmarks.size(); ++i) {
    const Eigen::Vector2d in_body = truth_.inverse() * world_.landmarks[i];
    const double range = in_body.norm();
    if (range > world_.reach_m) continue;
    const double range_noise = options_.range_noise_m + options_.range_noise_share * range;
    const double bearing_noise = options_.bearing_noise_deg * std::numbers::pi / 180.0;
    LandmarkSighting& seen = frame.landmarks.emplace_back();
    if (world_.named) seen.id = static_cast<std::int64_t>(i);
    seen.range = range + range_noise * random_.normal();
    seen.bearing = std::atan2(in_body.y(), in_body.x()) + bearing_noise * random_.normal();
  }
}

}  // namespace rastro::testing
