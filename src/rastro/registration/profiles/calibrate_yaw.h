// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace rastro {

struct YawCalibration {
  double lambda = 0.0;   ///< Radians per pixel.
  double rms_rad = 0.0;  ///< RMS of the residuals, robustly weighted.
  double sigma = 0.0;    ///< Standard deviation of lambda.
  int used = 0;          ///< Pairs with a weight above one half.
};

/// lambda of yaw = lambda * shift (METHODS 2.2) from shifts (pixels) and the yaw changes of a reference (radians,
/// positive to the left) over the same pairs of frames: least squares with outliers rejected (Tukey, its width from the
/// median of the residuals, weighted by the shifts: the camera may stand still most of the time). Throws Error for
/// fewer than 3 pairs or with hardly any rotation (shifts below 1 px).
YawCalibration calibrate_yaw(std::span<const double> shifts_px, std::span<const double> yaw_changes_rad);

}  // namespace rastro
