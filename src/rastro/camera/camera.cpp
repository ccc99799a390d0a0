// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/camera.h"

#include <cmath>
#include <numbers>

#include "rastro/camera/distortion.h"

namespace rastro {
namespace {

Eigen::Vector2d to_pixel(const Camera& camera, const Eigen::Vector2d& distorted) {
  return {camera.fx * distorted.x() + camera.cx, camera.fy * distorted.y() + camera.cy};
}

}  // namespace

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& point_in_camera) const {
  if (!(point_in_camera.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d ray = point_in_camera.head<2>() / point_in_camera.z();
  const auto distorted = distort(*this, ray);
  if (!distorted) return std::nullopt;
  return to_pixel(*this, *distorted);
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& point_in_camera,
                                               Eigen::Matrix<double, 2, 3>& jacobian) const {
  if (!(point_in_camera.z() > 0.0)) return std::nullopt;
  const double inverse_z = 1.0 / point_in_camera.z();
  const Eigen::Vector2d ray = point_in_camera.head<2>() / point_in_camera.z();
  Eigen::Matrix2d distorted_by_ray;
  const auto distorted = distort(*this, ray, distorted_by_ray);
  if (!distorted) return std::nullopt;
  Eigen::Matrix<double, 2, 3> ray_by_point;
  ray_by_point << inverse_z, 0.0, -ray.x() * inverse_z, 0.0, inverse_z, -ray.y() * inverse_z;
  jacobian = Eigen::Vector2d(fx, fy).asDiagonal() * distorted_by_ray * ray_by_point;
  return to_pixel(*this, *distorted);
}

std::optional<Eigen::Vector2d> Camera::unproject(const Eigen::Vector2d& pixel) const {
  return undistort(*this, Eigen::Vector2d((pixel.x() - cx) / fx, (pixel.y() - cy) / fy));
}

std::size_t Camera::coefficient_count() const {
  switch (distortion) {
    case Distortion::none:
      return 0;
    case Distortion::radial_tangential:
      return coefficients[4] != 0.0 ? 5 : 4;
    case Distortion::equidistant:
      return 4;
    case Distortion::rational:
      break;
  }
  return 8;
}

Camera Camera::scaled(double scale) const {
  Camera result = *this;
  result.width = static_cast<int>(std::lround(width * scale));
  result.height = static_cast<int>(std::lround(height * scale));
  result.fx *= scale;
  result.fy *= scale;
  // Pixel centers are integers: the image's corner is at (-0.5, -0.5) and is the fixed point of the scaling.
  result.cx = (cx + 0.5) * scale - 0.5;
  result.cy = (cy + 0.5) * scale - 0.5;
  return result;
}

Camera camera_from_field_of_view(double degrees, int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.5 * width / std::tan(0.5 * degrees * std::numbers::pi / 180.0);
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

}  // namespace rastro
