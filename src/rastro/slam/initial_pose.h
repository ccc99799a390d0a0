// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "rastro/math/se2.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// Makes a method whose own world is the body frame at the first frame.
using SlamMaker = std::function<std::unique_ptr<Slam>(const SlamContext&)>;

/// Makes a method with `make` and transforms its world by the context's initial pose: poses, covariances and maps
/// (those in the archive too) are in the new world; all else is unchanged. Without an initial pose, and with a given
/// map, which already has a world, `make` gets the context as it is. Error for an initial pose that is not finite.
std::unique_ptr<Slam> make_with_initial_pose(const SlamContext& context, const SlamMaker& make);

/// The context's initial pose for a planar method, the identity where there is none. Error naming `method` for one with
/// z, roll or pitch.
SE2 planar_initial_pose(const SlamContext& context, const std::string& method);

/// The same map in another world: keyframes and landmarks of all submaps are transformed, relative poses stay.
Map transformed(const Map& map, const SE3& new_world_from_world);

}  // namespace rastro
