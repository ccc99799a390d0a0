// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/sensor/frame.h"
#include "rastro/viewer/scene.h"

namespace rastro::detail {

/// The color image of a frame, or the gray one where there is none, reduced by a whole factor to sides of at most
/// `longest_px` and packed. `keyframe` of the result stays 0.
SceneImage small_image(const Frame& frame, int longest_px);

}  // namespace rastro::detail
