// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/feature_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "rastro/math/median.h"

namespace rastro {

double variance_ratio(const std::vector<PointMeasurement>& measured, const SE3& world_from_camera,
                      std::optional<double> ray_sigma) {
  constexpr double median_of_noise = 1.386;  // of chi squared with two degrees of freedom
  const SE3 camera_from_world = world_from_camera.inverse();
  std::vector<double> squares;
  for (const PointMeasurement& point : measured) {
    const Eigen::Vector3d p = camera_from_world * point.in_world;
    if (!(p.z() > 0.0)) continue;
    const double sigma = ray_sigma.value_or(point.ray_sigma);
    squares.push_back((p.head<2>() / p.z() - point.ray).squaredNorm() / (sigma * sigma));
  }
  return upper_median_or(std::move(squares), median_of_noise) / median_of_noise;
}

void FeatureNoise::learn(double variance_ratio) {
  constexpr std::size_t fewest = 5, most = 30;
  constexpr double largest = 4.0;  // Beyond that they would be no features any more.
  if (!std::isfinite(variance_ratio)) return;
  last_.push_back(factor_ * factor_ * variance_ratio);
  if (last_.size() > most) last_.pop_front();
  if (last_.size() < fewest) return;
  factor_ = std::clamp(std::sqrt(median({last_.begin(), last_.end()})), 1.0, largest);
}

}  // namespace rastro
