// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/image/image.h"

namespace rastro {

enum class OccluderShape { post, figure };

/// Appearance of one occluder; all lengths in pixels.
struct OccluderAppearance {
  OccluderShape shape = OccluderShape::post;
  double width_px = 100.0;    ///< Of the post, or from shoulder to shoulder of the figure.
  double height_px = 400.0;   ///< Of the image and of the tile.
  double tilt_rad = 0.0;      ///< Clockwise.
  double brightness = 110.0;  ///< Mean intensity, 0 to 255.
  double contrast = 40.0;     ///< Intensity difference between its light and its dark parts.
  double blur_px = 4.0;       ///< Length of the motion blur along x.
  std::uint64_t seed = 1;
};

/// Cut-out image of an occluder: intensity premultiplied by opacity, and opacity 0 to 1. Its margin is empty.
struct OccluderTile {
  Image<float> gray;
  Image<float> opacity;
};

/// Paints shape and texture: noise of many octaves, clothing or poster patches with their own corners, shading towards
/// the outline, soft edges. The same bytes for the same parameters.
OccluderTile paint_occluder(const OccluderAppearance& appearance);

}  // namespace rastro
