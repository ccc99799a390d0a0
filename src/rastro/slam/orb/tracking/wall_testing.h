// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro::testing {

constexpr double wall_m = 3.0;

/// For tests only: a wall `wall_m` in front of the left camera, with a texture that never repeats.
inline GrayImage image_of_wall(const Camera& camera, const SE3& left_from_camera) {
  GrayImage image(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = camera.unproject({x, y});
      if (!ray) continue;
      const Eigen::Vector3d direction = left_from_camera.rotation() * Eigen::Vector3d(ray->x(), ray->y(), 1.0);
      const Eigen::Vector3d center = left_from_camera.translation();
      const Eigen::Vector3d at = center + direction * ((wall_m - center.z()) / direction.z());
      const double u = 100.0 * at.x(), v = 100.0 * at.y();
      const double wave = std::sin(0.23 * u + 0.11 * v) + std::sin(0.19 * v - 0.013 * u * std::sin(0.05 * v)) +
                          std::sin(0.31 * u - 0.0002 * u * v);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(128.0 + 40.0 * wave));
    }
  }
  return image;
}

}  // namespace rastro::testing
