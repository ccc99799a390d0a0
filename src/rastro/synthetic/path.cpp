// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/path.h"

#include <cmath>

namespace rastro {

SE3 CameraPath::world_from_camera(double time_s) const {
  if (exact_) return exact_(time_s);
  const double knots = time_s / spacing_s_;
  const auto first = static_cast<std::int64_t>(std::floor(knots));
  const double f = knots - static_cast<double>(first);
  const SE3 controls[4] = {controls_(first - 1), controls_(first), controls_(first + 1), controls_(first + 2)};
  // Cumulative B-spline weights from the second, third and fourth control on.
  const double from_second = (5.0 + 3.0 * f - 3.0 * f * f + f * f * f) / 6.0;
  const double from_third = (1.0 + 3.0 * f + 3.0 * f * f - 2.0 * f * f * f) / 6.0;
  const double from_fourth = f * f * f / 6.0;
  const double weights[3] = {from_second, from_third, from_fourth};
  Eigen::Vector3d position = controls[0].translation();
  SO3 rotation = controls[0].rotation();
  for (int i = 0; i < 3; ++i) {
    position += weights[i] * (controls[i + 1].translation() - controls[i].translation());
    rotation = rotation * SO3::exp(weights[i] * (controls[i].rotation().inverse() * controls[i + 1].rotation()).log());
  }
  return {rotation, position};
}

SO3 looking(double yaw, double pitch, double roll) {
  Eigen::Matrix3d world_from_level;
  // Camera x is the world's -y, camera y the world's -z, camera z the world's x.
  world_from_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const SO3 yaw_pitch = SO3::exp({0, 0, yaw}) * SO3::exp({0, pitch, 0});
  return yaw_pitch * SO3::from_matrix(world_from_level) * SO3::exp({0, 0, roll});
}

}  // namespace rastro
