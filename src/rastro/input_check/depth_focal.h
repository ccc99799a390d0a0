// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/input_check/tracked_window.h"

namespace rastro {

/// A focal length by its logarithm, as a share of the calibrated one.
struct FocalFit {
  double log_factor = 0.0;  ///< Of the true over the calibrated focal length.
  double sigma = 1.0;       ///< Of `log_factor`, by the residuals.
};

/// The focal length with which depth and features of the first and the last frame of a window show one rigid scene.
/// With a wrong one the scene is stretched sideways against its depth, so that a rotation makes the depths change by
/// more or less than they do. Depths that are all too long or too short by one factor make no difference. nullopt
/// without depth in both frames, or where no motion explains them.
std::optional<FocalFit> focal_from_depth(const TrackedWindow& window, const Camera& camera);

}  // namespace rastro
