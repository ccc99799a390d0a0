// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/undistorted_camera.h"

#include <limits>

namespace rastro {

Eigen::Vector2f UndistortedCamera::from_pixel(const Eigen::Vector2f& pixel) const {
  if (is_identity()) return pixel;
  const Eigen::Vector2f ray = ray_of(pixel);
  if (!ray.allFinite()) return pixel;
  return {static_cast<float>(camera_->fx) * ray.x() + static_cast<float>(camera_->cx),
          static_cast<float>(camera_->fy) * ray.y() + static_cast<float>(camera_->cy)};
}

std::optional<Eigen::Vector2d> UndistortedCamera::to_pixel(const Eigen::Vector2d& ideal) const {
  if (is_identity()) return ideal;
  return camera_->project({(ideal.x() - camera_->cx) / camera_->fx, (ideal.y() - camera_->cy) / camera_->fy, 1.0});
}

Eigen::Vector2f UndistortedCamera::ray_of(const Eigen::Vector2f& pixel) const {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  if (!camera_) return {none, none};
  const auto ray = camera_->unproject(pixel.cast<double>());
  return ray ? Eigen::Vector2f(ray->cast<float>()) : Eigen::Vector2f(none, none);
}

}  // namespace rastro
