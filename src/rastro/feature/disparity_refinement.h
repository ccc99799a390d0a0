// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/image.h"

namespace rastro {

struct DisparityRefinementOptions {
  int iterations = 2;
  int reach_px = 4;           ///< Windows have 2 * reach + 1 pixels in each direction; 7 at most.
  double most_step_px = 1.0;  ///< In one iteration.
  /// Mean squared gradient from which a window says more than the disparity given: without texture that one stays.
  double least_texture = 4.0;
  /// Variance of the difference between both windows, relative to that of the left one, from which they show different
  /// surfaces.
  double most_difference = 0.5;
  double noise_variance = 25.0;  ///< Of that difference, squared intensity, where the images are equal.
};

/// Makes the disparities of a rectified pair precise (Lucas and Kanade 1981, along the row): the shift by which the
/// windows around each pixel fit best, whatever their brightness. Each pixel of a window has its own disparity, so that
/// slanted surfaces have no bias. Pixels that do not fit lose their disparity; 0: none. Sums are of integers: the
/// result depends on no order.
void refine_disparity(GrayView left, GrayView right, const DisparityRefinementOptions& options,
                      Image<float>& disparity);

}  // namespace rastro
