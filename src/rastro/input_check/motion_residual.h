// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/input_check/tracked_window.h"

namespace rastro {

/// How well a rigid scene seen by this camera explains the features of a window, pixels: the robust RMS of what three
/// of its frames leave; with depth, of the pose from the first frame's points. nullopt where too few can be used.
std::optional<double> motion_residual(const TrackedWindow& window, const Camera& camera);

/// That of the pose from depth alone: with the depths as they are, and with those mirrored left to right, over features
/// that have both.
struct MirrorResiduals {
  double given_px = 0.0, mirrored_px = 0.0;
};
std::optional<MirrorResiduals> mirror_residuals(const TrackedWindow& window, const Camera& camera);

}  // namespace rastro
