// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/depth_reading.h"

#include <Eigen/Dense>
#include <cmath>

namespace rastro {
namespace {

constexpr int reach = 2;
constexpr int least_pixels = 15;

struct Plane {
  double inverse_depth = 0.0;
  int pixels = 0;
};

/// The inverse depth of a plane is linear in the image.
std::optional<Plane> plane_at(const DepthImage& depth, const Eigen::Vector2d& pixel, const RgbdOptions& options) {
  const int cx = static_cast<int>(std::lround(pixel.x())), cy = static_cast<int>(std::lround(pixel.y()));
  if (cx < reach || cy < reach || cx + reach >= depth.width() || cy + reach >= depth.height()) return std::nullopt;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0.0;
  int pixels = 0;
  for (int y = cy - reach; y <= cy + reach; ++y) {
    for (int x = cx - reach; x <= cx + reach; ++x) {
      const double z = static_cast<double>(depth.at(x, y));
      if (!(z >= options.min_depth_m && z <= options.max_depth_m)) continue;
      const Eigen::Vector3d row(x - pixel.x(), y - pixel.y(), 1.0);
      normal += row * row.transpose();
      right += row / z;
      squares += 1.0 / (z * z);
      ++pixels;
    }
  }
  if (pixels < least_pixels) return std::nullopt;
  const Eigen::Vector3d plane = normal.inverse() * right;
  const double rms = std::sqrt(std::max(0.0, squares - plane.dot(right)) / pixels);
  const double sigma = inverse_depth_sigma(options, plane.z());
  if (!(plane.z() > 0.0) || rms > options.depth_edge_sigmas * sigma) return std::nullopt;
  // Nearly edge-on: a pixel's error changes the depth much.
  if (plane.head<2>().norm() > options.depth_edge_sigmas * sigma) return std::nullopt;
  return Plane{plane.z(), pixels};
}

}  // namespace

double inverse_depth_sigma(const RgbdOptions& options, double inverse_depth) {
  return options.depth_sigma_m * inverse_depth * inverse_depth + options.depth_sigma_per_m2;
}

std::optional<DepthReading> read_depth(const DepthImage& depth, const Camera& camera, const Eigen::Vector2d& ray,
                                       const SE3& depth_from_color, const RgbdOptions& options) {
  const Eigen::Vector3d direction(ray.x(), ray.y(), 1.0);
  const auto far = camera.project(depth_from_color.rotation() * direction);
  if (!far) return std::nullopt;
  auto plane = plane_at(depth, *far, options);
  if (!plane) return std::nullopt;
  // Once more at the pixel to which this depth moves it.
  const auto pixel = camera.project(depth_from_color * Eigen::Vector3d(direction / plane->inverse_depth));
  if (!pixel) return std::nullopt;
  plane = plane_at(depth, *pixel, options);
  if (!plane) return std::nullopt;
  // z_depth = (R (ray z) + t)_z, solved for z.
  const double z_in_depth = 1.0 / plane->inverse_depth;
  const double z = (z_in_depth - depth_from_color.translation().z()) / (depth_from_color.rotation() * direction).z();
  if (!(z >= options.min_depth_m && z <= options.max_depth_m)) return std::nullopt;
  return DepthReading{1.0 / z, inverse_depth_sigma(options, 1.0 / z), 0.0};
}

}  // namespace rastro
