// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace rastro {

/// One point of a surface, from all measurements that fell into its voxel.
struct CloudPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< World, meters.
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();    ///< Unit length, toward the camera; zero: unknown.
  std::array<std::uint8_t, 3> color{};                 ///< Red, green, blue.
  std::uint32_t count = 0;                             ///< Measurements.
  float sigma = 0.0F;  ///< Of the position along the normal, the map's unit; 0: unknown.
};

struct PointCloud {
  std::vector<CloudPoint> points;  ///< In an order that depends on the points alone.
  double voxel_m = 0.0;            ///< Side of the voxels it was filtered with; 0: not filtered.
};

}  // namespace rastro
