// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/competing_motions.h"

#include <cmath>
#include <numbers>

#include "rastro/multiview/essential.h"

namespace rastro {
namespace {

/// Directions of one half of the sphere, evenly spread (a Fibonacci lattice): the essential matrix has no sign.
std::vector<Eigen::Vector3d> half_sphere(int count) {
  constexpr double golden_angle = std::numbers::pi * (3.0 - 2.23606797749979);
  std::vector<Eigen::Vector3d> directions;
  for (int k = 0; k < count; ++k) {
    const double z = (k + 0.5) / count, radius = std::sqrt(1.0 - z * z), angle = k * golden_angle;
    directions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return directions;
}

}  // namespace

std::vector<SE3> competing_motions(const SE3& found, std::span<const Eigen::Vector2d> a,
                                   std::span<const Eigen::Vector2d> b, std::span<const std::uint8_t> is_inlier,
                                   double least_angle_deg) {
  constexpr int start_count = 16;
  const double nearest = std::cos(least_angle_deg * std::numbers::pi / 180.0);
  const Eigen::Vector3d direction = found.translation().normalized();
  std::vector<SE3> others;
  for (const Eigen::Vector3d& start : half_sphere(start_count)) {
    const auto refined = refine_relative_pose(SE3(found.rotation(), start), a, b, is_inlier);
    if (refined && std::abs(refined->translation().dot(direction)) <= nearest) others.push_back(*refined);
  }
  return others;
}

}  // namespace rastro
