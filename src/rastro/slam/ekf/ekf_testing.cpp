// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/ekf_testing.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace rastro::testing {

LandmarkWorld ring_world(std::size_t landmarks, std::uint64_t seed) {
  LandmarkWorld world;
  Random random(seed);
  const Eigen::Vector2d center(0.0, world.radius_m);
  while (world.landmarks.size() < landmarks) {
    const SO2 direction = SO2::from_angle(random.uniform(-std::numbers::pi, std::numbers::pi));
    const Eigen::Vector2d position =
        center + direction * Eigen::Vector2d(world.radius_m + random.uniform(-2.5, 4.0), 0.0);
    const bool crowded = std::any_of(world.landmarks.begin(), world.landmarks.end(),
                                     [&](const Eigen::Vector2d& other) { return (other - position).norm() < 1.0; });
    if (!crowded) world.landmarks.push_back(position);
  }
  return world;
}

LandmarkWorld room_world() {
  LandmarkWorld world;
  const double y = world.radius_m;
  world.walls.add_polygon({{-7.0, y - 7.0},
                           {7.0, y - 7.0},
                           {7.0, y + 2.0},
                           {8.5, y + 2.0},
                           {8.5, y + 4.0},
                           {7.0, y + 4.0},
                           {7.0, y + 7.0},
                           {-7.0, y + 7.0}});
  for (const double x : {-1.2, 1.0}) {
    world.walls.add_polygon({{x, y - 0.5}, {x, y + 0.2}, {x + 0.6, y + 0.2}, {x + 0.6, y - 0.5}});
  }
  world.walls.poles = {{{5.6, y - 5.0}, 0.05}, {{-5.5, y + 5.2}, 0.05}};
  return world;
}

Frame LandmarkDrive::next() {
  Frame frame;
  if (frames_ > 0) {
    const SE2 motion = SE2::exp({world_.step_m, 0.0, world_.step_m / world_.radius_m});
    ground_truth_ = ground_truth_ * motion;
    odometry_ = odometry_ * noisy(motion);
  }
  frame.index = frames_;
  frame.stamp = 100'000'000 * ++frames_;
  frame.odometry_from_body = odometry_;
  see(frame);
  if (!world_.walls.walls.empty()) {
    constexpr double full_circle = 2.0 * std::numbers::pi * 360.0 / 361.0;
    frame.scan = scan_of(world_.walls, ground_truth_, 361, full_circle, world_.beam_noise_m, random_);
  }
  return frame;
}

SE2 LandmarkDrive::noisy(const SE2& motion) {
  // From the definition of the options, not from the filter's motion model: an error there must be detected.
  constexpr double rad_per_deg = std::numbers::pi / 180.0;
  const double path_m = motion.translation().norm(), rotation_deg = std::abs(motion.rotation().angle()) / rad_per_deg;
  const double along = options_.odometry_error_m_per_m * std::sqrt(path_m);
  const double angle = rad_per_deg * std::hypot(options_.odometry_error_deg_per_45_deg * std::sqrt(rotation_deg / 45.0),
                                                options_.heading_error_deg_per_m * std::sqrt(path_m));
  const Eigen::Vector3d sigma = world_.odometry_scale * Eigen::Vector3d(along, along, angle);
  const Eigen::Vector2d translation =
      motion.translation() + Eigen::Vector2d(sigma.x() * random_.normal(), sigma.y() * random_.normal());
  return {motion.rotation() * SO2::from_angle(sigma.z() * random_.normal()), translation};
}

void LandmarkDrive::see(Frame& frame) {
  for (std::size_t i = 0; i < world_.landmarks.size(); ++i) {
    const Eigen::Vector2d in_body = ground_truth_.inverse() * world_.landmarks[i];
    const double range = in_body.norm();
    if (range > world_.reach_m) continue;
    const double range_noise = options_.range_noise_m + options_.range_noise_share * range;
    const double bearing_noise = options_.bearing_noise_deg * std::numbers::pi / 180.0;
    LandmarkMeasurement& seen = frame.landmarks.emplace_back();
    if (world_.named) seen.id = static_cast<std::int64_t>(i);
    seen.range = range + range_noise * random_.normal();
    seen.bearing = std::atan2(in_body.y(), in_body.x()) + bearing_noise * random_.normal();
  }
}

void WallWorld::add_polygon(const std::vector<Eigen::Vector2d>& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) walls.push_back({corners[i], corners[(i + 1) % corners.size()]});
}

double WallWorld::distance(const Eigen::Vector2d& from, const Eigen::Vector2d& direction) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls) {
    Eigen::Matrix2d system;
    system << direction, wall.from - wall.to;
    if (std::abs(system.determinant()) < 1e-12) continue;
    const Eigen::Vector2d hit = system.inverse() * (wall.from - from);
    if (hit.x() > 0.0 && hit.y() >= 0.0 && hit.y() <= 1.0) nearest = std::min(nearest, hit.x());
  }
  for (const Pole& pole : poles) {
    const Eigen::Vector2d to_middle = pole.middle - from;
    const double along = to_middle.dot(direction);
    const double inside = pole.radius * pole.radius - (to_middle.squaredNorm() - along * along);
    if (along > 0.0 && inside >= 0.0) nearest = std::min(nearest, along - std::sqrt(inside));
  }
  return nearest;
}

LaserScan scan_of(const WallWorld& world, const SE2& world_from_laser, std::size_t beams, double span, double noise_m,
                  Random& random) {
  LaserScan scan;
  scan.first_angle = -0.5 * span;
  scan.angle_step = span / static_cast<double>(beams - 1);
  scan.max_range = 80.0;
  for (std::size_t beam = 0; beam < beams; ++beam) {
    const Eigen::Vector2d direction =
        world_from_laser.rotation() * (SO2::from_angle(scan.angle_of(beam)) * Eigen::Vector2d(1.0, 0.0));
    const double range = world.distance(world_from_laser.translation(), direction);
    scan.ranges.push_back(static_cast<float>(std::min(range + noise_m * random.normal(), scan.max_range)));
  }
  return scan;
}

}  // namespace rastro::testing
