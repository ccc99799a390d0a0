// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/camera/camera.h"
#include "rastro/map/graph/map.h"
#include "rastro/slam/rgbd/options.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// What all maps of a run share.
Map base_map(const RgbdSlamOptions& options, const Camera& camera);

/// Prepares the given map for this method, keyframes numbered from 0. Error where it lacks what relocalization needs,
/// and for a map from another camera.
SlamContext with_usable_map(SlamContext context, const Camera& camera);

}  // namespace rastro
