// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/input_check/tracked_window.h"
#include "rastro/optimize/window_refinement.h"

namespace rastro {

/// Some frames of a window and the features followed through all of them, adjusted: poses in the frame of the first
/// camera, at an arbitrary scale. nullopt where too few features remain or the motion leaves no parallax.
std::optional<RefinementWindow> adjusted_bundle(const TrackedWindow& window, const Camera& camera);

}  // namespace rastro
