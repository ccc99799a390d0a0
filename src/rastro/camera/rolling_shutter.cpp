// SPDX-License-Identifier: Apache-2.0
#include "rastro/camera/rolling_shutter.h"

#include "rastro/math/so3.h"

namespace rastro {

PixelAtMiddleRow at_middle_row(const Camera& camera, const Eigen::Vector2d& pixel,
                               const Eigen::Vector3d& angular_velocity) {
  if (camera.readout_s <= 0.0 || camera.height < 2) return {pixel};
  const auto ray = camera.unproject(pixel);
  if (!ray) return {pixel};
  const double read_after_middle_s = (pixel.y() / (camera.height - 1) - 0.5) * camera.readout_s;
  const Eigen::Vector3d at_middle = SO3::exp(-read_after_middle_s * angular_velocity) * ray->homogeneous();
  const auto moved = camera.project(at_middle);
  return moved ? PixelAtMiddleRow{*moved, at_middle.z()} : PixelAtMiddleRow{pixel};
}

}  // namespace rastro
