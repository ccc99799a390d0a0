// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/backend/rgbd/options.h"
#include "rastro/camera/camera.h"
#include "rastro/map/graph/map.h"
#include "rastro/map/signatures/signature_layer.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// What all maps of a run share.
Map base_map(const std::string& method, const RgbdSlamOptions& options, const Camera& camera, double baseline = 0.0);

/// Prepares the given map for these methods: keyframes numbered from 0, with a feature layer, whose features stay in
/// long-term memory where the map is to be continued. Error where it lacks what relocalization needs, for a map from
/// another camera, and for one whose features cannot be compared with those of this run.
SlamContext with_usable_map(SlamContext context, const Camera& camera, const RgbdSlamOptions& options = {});

/// From the signatures, else the features of a map; without an image where it has neither.
Signature signature_of(const Map& map, KeyframeId id);

}  // namespace rastro
