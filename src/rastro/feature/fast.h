// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/image/padded_image.h"

namespace rastro {

/// A corner with the scores around it.
struct FastCorner {
  std::int16_t x = 0, y = 0;
  std::uint8_t score = 0;
  std::uint8_t left = 0, right = 0, above = 0, below = 0;
};

/// Radius of the circle around a pixel.
constexpr int fast_radius = 3;

/// FAST-9/16 (Rosten and Drummond 2006). A pixel's score is the largest number by which nine pixels in a row, of the 16
/// on a circle around it, are all brighter or all darker than it; scores up to `threshold` count as zero. Appends, row
/// by row, the pixels of columns x0..x1-1, rows y0..y1-1 whose score no neighbor exceeds (of equal ones the upper,
/// then the left one wins). The image's padding must reach fast_padding beyond the area.
constexpr int fast_padding = 40;
void fast_corners(const PaddedImage& image, int x0, int x1, int y0, int y1, int threshold,
                  std::vector<FastCorner>& corners);

}  // namespace rastro
