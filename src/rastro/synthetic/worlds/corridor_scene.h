// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/synthetic/laser_world.h"
#include "rastro/synthetic/scene.h"

namespace rastro::corridor {

// The corridors run around a block of rooms; their walls are at these lines (meters, in the world of the drive).
constexpr double outer_west = -9.0, outer_east = 21.0, outer_south = -1.0, outer_north = 9.0;
constexpr double inner_west = -7.0, inner_east = 19.0, inner_south = 1.0, inner_north = 7.0;
/// The building.
constexpr double far_west = -13.0, far_east = 25.0, far_south = -6.0;
constexpr double ceiling_m = 2.6;

struct Floor {
  std::unique_ptr<Scene> scene = std::make_unique<Scene>();
  std::vector<GlassPane> panes;
  std::vector<LaserLandmark> landmarks;
};

/// Walls, doors, furniture and a person; not painted, its tree not built. Furniture depends on the seed; walls and the
/// person's path do not.
Floor build_floor(std::uint64_t seed);

/// The furniture of the rooms and corridors.
void add_furniture(Scene& scene, Random& random);
/// A person who crosses the first corridor in front of the robot, and later walks towards it, twice.
void add_person(Scene& scene);

/// A box from one corner to the other.
std::uint32_t add_block(Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                        const Material& material);

}  // namespace rastro::corridor
