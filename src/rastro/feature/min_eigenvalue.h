// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/padded_image.h"

namespace rastro {

/// Reads up to this many pixels around the requested area.
constexpr int min_eigenvalue_margin = 2;

/// Shi and Tomasi 1994: twice the smaller eigenvalue of the structure tensor of Sobel gradients summed over 3x3 pixels,
/// for the pixels of rows [y0, y1) and columns [x0, x1). `scores` has row y at scores + (y - y0) * stride, its pixel x0
/// first, and room for 16 more values than a row. `scratch` keeps memory between calls.
struct MinEigenvalueScratch {
  Image<std::int16_t> gradient_x, gradient_y;
};
void min_eigenvalues(const PaddedImage& image, int x0, int x1, int y0, int y1, float* scores, std::ptrdiff_t stride,
                     MinEigenvalueScratch& scratch);

}  // namespace rastro
