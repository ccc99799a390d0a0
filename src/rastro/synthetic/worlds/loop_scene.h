// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "rastro/base/random.h"
#include "rastro/synthetic/scene.h"

namespace rastro::loop {

/// World frame: x east, y north, z up, the ground at z = 0. Painted.
std::unique_ptr<Scene> build_scene(std::uint64_t seed, int threads, double detail);

/// Position of the camera in the room that the images show for two seconds.
inline const Eigen::Vector3d elsewhere_position(60.0, -40.0, 1.5);

/// Crates, drums, boards and the like along the path; different ones for another `random`.
void add_things(Scene& scene, Random& random);
/// Signs on the walls.
void add_signs(Scene& scene, Random& random);
/// People who walk up and down the street in the east; must be added last.
void add_crowd(Scene& scene);

std::uint32_t add_block(Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                        const Material& material);

}  // namespace rastro::loop
