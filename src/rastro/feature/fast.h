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

/// A pixel of the circle is read this far away.
constexpr int fast_radius = 3;

/// FAST-9/16 (Rosten and Drummond 2006). A pixel's score is the largest number by which nine pixels in a row, of the 16
/// on a circle around it, are all brighter or all darker than it; scores up to `threshold` count as none. Appends the
/// pixels of columns x0..x1-1, rows y0..y1-1 whose score no neighbour beats (of equal ones the upper, then the left one
/// wins), row by row. The image's padding is at least fast_padding beyond what the area leaves of the image's border.
constexpr int fast_padding = 40;
void fast_corners(const PaddedImage& image, int x0, int x1, int y0, int y1, int threshold,
                  std::vector<FastCorner>& corners);

}  // namespace rastro
