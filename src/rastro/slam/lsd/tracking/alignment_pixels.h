// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rastro/image/pyramid.h"
#include "rastro/slam/lsd/inverse_depth_map.h"

namespace rastro {

/// A pixel that constrains the motion of a camera, if its depth is known.
struct AlignmentPixel {
  std::uint16_t x = 0, y = 0;
  std::int16_t twice_gradient_x = 0, twice_gradient_y = 0;  ///< Central differences, levels per pixel.

  int strength() const { return twice_gradient_x * twice_gradient_x + twice_gradient_y * twice_gradient_y; }
};

/// The pixels of one level of an image with sufficient gradient, in tiles of 32 x 32. They stay as they are while their
/// depths improve.
class AlignmentPixels {
 public:
  /// `min_gradient`: intensity levels per pixel.
  AlignmentPixels(const PaddedImage& image, double min_gradient);

  /// Those with a known depth, tile by tile. Beyond `max_points` each tile keeps its share of those with the strongest
  /// gradients; 0: no limit.
  std::vector<AlignmentPixel> known_ones(const InverseDepthMap& depth, std::size_t max_points) const;

 private:
  std::vector<AlignmentPixel> pixels_;
  std::vector<std::size_t> tile_ends_;
};

/// Of each level.
std::vector<AlignmentPixels> alignment_pixels(const Pyramid& image, int levels, double min_gradient);

}  // namespace rastro
