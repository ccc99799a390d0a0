// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/sensor/frame.h"
#include "rastro/sensor/source.h"
#include "rastro/viewer/live_messages.h"

namespace rastro {

/// A frame of a recording as the page reads it, see README.md: its image, small, and what its depth image (where the
/// recording has a calibration) or its scan measured as points, thinned. Points are in the camera frame, of a scan in
/// the body frame. `features`: of the image, where something found some.
std::string frame_block(const Frame& frame, const SourceInfo& recording, const LiveFeatures* features = nullptr);

}  // namespace rastro
