// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/image.h"

namespace rastro {

/// Pixels at the edge of a keyframe that get no depth: no room for samples.
constexpr int depth_border = 4;

/// 1 where the pixel or one beside it has at least this gradient (intensity levels per pixel) and the samples around it
/// may be used, else 0. `usable`: zero where a pixel must not be used; empty: all may.
Image<std::uint8_t> gradient_mask(GrayView image, float min_gradient, GrayView usable);

}  // namespace rastro
