// SPDX-License-Identifier: Apache-2.0
// KITTI raw's GPS/IMU packets of a generated world.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "rastro/synthetic/write_kitti.h"

namespace rastro {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr double earth_radius_m = 6378137.0;
constexpr double start_latitude = 49.0, start_longitude = 8.4, start_altitude_m = 115.0;  // Degrees.
constexpr double gravity = 9.81;

/// Inverse of the Mercator projection that the readers of these packets use.
struct GeoPosition {
  double latitude, longitude;
};
GeoPosition geo_position(double east_m, double north_m) {
  const double scale = std::cos(start_latitude * degree);
  const double start = std::log(std::tan((90.0 + start_latitude) * degree / 2.0));
  const double latitude = 2.0 * std::atan(std::exp(start + north_m / (scale * earth_radius_m))) / degree - 90.0;
  return {latitude, start_longitude + east_m / (scale * earth_radius_m) / degree};
}

SE3 world_from_body(const World& world, double time_s) {
  return world.world_from_camera_at(time_s) * world.body_from_camera().inverse();
}

std::string three(const Eigen::Vector3d& v) { return fmt::format(" {:.9f} {:.9f} {:.9f}", v.x(), v.y(), v.z()); }

}  // namespace

std::string oxts_line(const World& world, std::int64_t frame) {
  const double time = static_cast<double>(frame) / world.rate_hz(), half = 5e-3;
  const SE3 start = world_from_body(world, 0.0), now = world_from_body(world, time),
            before = world_from_body(world, time - half), after = world_from_body(world, time + half);
  const Eigen::Vector3d moved = now.translation() - start.translation();
  const GeoPosition position = geo_position(moved.x(), moved.y());
  const Eigen::Matrix3d rotation = now.rotation().matrix();  // Rz(yaw) Ry(pitch) Rx(roll)
  const double roll = std::atan2(rotation(2, 1), rotation(2, 2)), pitch = -std::asin(rotation(2, 0)),
               yaw = std::atan2(rotation(1, 0), rotation(0, 0));
  const Eigen::Vector3d velocity = (after.translation() - before.translation()) / (2.0 * half);
  const Eigen::Vector3d acceleration =
      (after.translation() - 2.0 * now.translation() + before.translation()) / (half * half) +
      Eigen::Vector3d(0, 0, gravity);
  const Eigen::Vector3d angular_velocity = (before.rotation().inverse() * after.rotation()).log() / (2.0 * half);
  // Forward, left and up in the horizontal plane, rotated by the yaw only.
  const SO3 level_from_world = SO3::exp({0, 0, -yaw});
  const SO3 body_from_world = now.rotation().inverse();
  return fmt::format("{:.13f} {:.13f} {:.9f} {:.12f} {:.12f} {:.12f} {:.9f} {:.9f}", position.latitude,
                     position.longitude, start_altitude_m + moved.z(), roll, pitch, yaw, velocity.y(), velocity.x()) +
         three(level_from_world * velocity) + three(body_from_world * acceleration) +
         three(level_from_world * acceleration) + three(angular_velocity) +
         three(level_from_world * (now.rotation() * angular_velocity)) + " 0.05 0.01 4 10 5 5 6";
}

}  // namespace rastro
