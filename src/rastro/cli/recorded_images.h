// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/cli/keyframe_images.h"
#include "rastro/map/graph/map.h"

namespace rastro::cli {

/// The map of a depth camera that holds no images, with those of its keyframes read from the recording that it was made
/// of: all are in memory. Error for the map of another camera, and where the recording cannot be read or lacks
/// frames of keyframes.
std::shared_ptr<const Map> with_recorded_images(const Map& map, const RecordingOfRun& recording);

}  // namespace rastro::cli
