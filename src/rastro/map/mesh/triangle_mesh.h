// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace rastro {

struct MeshVertex {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< World, meters.
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();    ///< Unit length, out of the solid; zero: unknown.
  std::array<std::uint8_t, 3> color{};                 ///< Red, green, blue.
};

/// Surfaces as triangles; corners are counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<MeshVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Into vertices.
};

}  // namespace rastro
