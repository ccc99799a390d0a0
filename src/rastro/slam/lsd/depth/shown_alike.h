// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/image/image.h"

namespace rastro {

/// When two images count as showing the same point.
struct ShownAlikeOptions {
  double gain = 1.0, offset = 0.0;  ///< Intensity in the other image = gain * intensity here + offset.
  double intensity_sigma = 3.0;     ///< Of one image.
  double position_variance = 1.0;   ///< Of the point's position in the other image, squared pixels.
  double max_sigmas = 3.0;
};

/// Whether the intensity of a pixel is found at `there` in the other image, up to noise and to what the error of the
/// position changes where one of both has gradient. Both are at least a pixel from the edge of their image.
bool is_shown_alike(GrayView here, int x, int y, GrayView other, const Eigen::Vector2d& there,
                    const ShownAlikeOptions& options);

}  // namespace rastro
