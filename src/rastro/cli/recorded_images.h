// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/cli/keyframe_images.h"
#include "rastro/map/graph/map.h"

namespace rastro::cli {

/// A map that holds no images, with those of its keyframes read from the recordings that it was made of, and their
/// depth where the map is that of a depth camera: all are in memory. Error for the map of a laser, and where a
/// recording cannot be read or lacks frames of keyframes.
std::shared_ptr<const Map> with_recorded_images(const Map& map, const std::vector<MapRecording>& recordings);

}  // namespace rastro::cli
