// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/weak_direction.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstddef>

#include "rastro/registration/scan_to_map.h"

namespace rastro {

WeakDirection weak_direction(std::span<const Eigen::Vector2d> points) {
  constexpr double base_m = 0.3, gap_m = 0.5;
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0, j = 0; i < points.size(); ++i) {
    // The base must be long enough, or range noise would rotate the normals.
    j = std::max(j, i);
    while (j + 1 < points.size() && (points[j] - points[i]).norm() < base_m &&
           (points[j + 1] - points[j]).norm() < gap_m)
      ++j;
    const Eigen::Vector2d along = points[j] - points[i];
    if (along.norm() < base_m) continue;
    const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
    normals += normal * normal.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(normals);
  return {solver.eigenvectors().col(0), solver.eigenvalues()[0] / std::max(1.0, solver.eigenvalues()[1])};
}

std::vector<Eigen::Vector2d> structure_of(const Submap& map, std::span<const Eigen::Vector2d> points,
                                          const SE2& submap_from_body) {
  constexpr std::size_t few = 5;
  if (map.key_scans().size() < few) return {points.begin(), points.end()};
  return agreeing_points(map.levels().front(), points, submap_from_body);
}

}  // namespace rastro
