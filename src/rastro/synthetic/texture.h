// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/image/image.h"

namespace rastro {

/// A grey picture with halved copies of itself (mip maps, Williams 1983), for looking up the mean grey of any
/// footprint.
class Texture {
 public:
  Texture() = default;
  /// Values are clamped to 0..255 and rounded.
  explicit Texture(const Image<float>& values);

  bool empty() const { return levels_.empty(); }
  std::size_t bytes() const;
  const GreyImage& level(int index) const { return levels_[static_cast<std::size_t>(index)]; }

  /// Mean grey around (x, y), in texels of the finest level with the first texel's corner at 0, over a footprint
  /// spanned by the two vectors (texels per pixel along the picture's x and y). Long footprints are sampled several
  /// times along their long side.
  float sample(float x, float y, float dx_dx, float dy_dx, float dx_dy, float dy_dy) const;

 private:
  float trilinear(float x, float y, float level) const;
  std::vector<GreyImage> levels_;
};

}  // namespace rastro
