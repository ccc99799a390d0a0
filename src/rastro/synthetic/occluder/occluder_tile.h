// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "rastro/image/image.h"

namespace rastro {

enum class OccluderShape { post, figure };

/// How one occluder looks; all lengths in pixels.
struct OccluderLook {
  OccluderShape shape = OccluderShape::post;
  double width_px = 100.0;    ///< Of the post, or from shoulder to shoulder of the figure.
  double height_px = 400.0;   ///< Of the picture to be crossed: the tile is as high.
  double tilt_rad = 0.0;      ///< Lean of the whole, clockwise.
  double brightness = 110.0;  ///< Mean grey, 0 to 255.
  double contrast = 40.0;     ///< Grey levels between its light and its dark parts.
  double blur_px = 4.0;       ///< Length of the motion blur along x.
  std::uint64_t seed = 1;
};

/// The picture of an occluder, cut out: grey already multiplied by opacity, and opacity 0 to 1. Its own margin is
/// empty.
struct OccluderTile {
  Image<float> grey;
  Image<float> opacity;
};

/// Paints shape and texture: noise of many octaves, clothing or poster patches with corners of their own, shading
/// towards the outline, soft edges. The same bytes for the same look.
OccluderTile paint_occluder(const OccluderLook& look);

}  // namespace rastro
