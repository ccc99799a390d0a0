// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "rastro/image/image.h"
#include "rastro/synthetic/paint/tint.h"

namespace rastro {

/// A gray image with halved copies of itself (mip maps, Williams 1983), for the mean intensity of any footprint.
class Texture {
 public:
  Texture() = default;
  /// Values are clamped to 0..255 and rounded.
  explicit Texture(const Image<float>& values);

  bool empty() const { return levels_.empty(); }
  std::size_t bytes() const;
  const GrayImage& level(int index) const { return levels_[static_cast<std::size_t>(index)]; }

  /// Mean intensity around (x, y), in texels of the finest level with the first texel's corner at 0, over a footprint
  /// spanned by the two vectors (texels per pixel along the image's x and y). Long footprints are sampled several times
  /// along their long side.
  float sample(float x, float y, float dx_dx, float dy_dx, float dx_dy, float dy_dy) const;

 private:
  float trilinear(float x, float y, float level) const;
  std::vector<GrayImage> levels_;
};

/// The same in color: red, green, blue and an unused channel in each texel, sampled together.
class ColorTexture {
 public:
  ColorTexture() = default;
  /// Intensities times the tint that `ink_of` names for each texel; the first one if `ink_of` is empty.
  ColorTexture(const Image<float>& values, const Image<std::uint8_t>& ink_of, std::span<const Tint> inks);

  bool empty() const { return levels_.empty(); }
  std::size_t bytes() const;
  /// The mean color: red, green and blue, 0..255.
  Eigen::Array4f mean() const;
  /// As Texture::sample().
  Eigen::Array4f sample(float x, float y, float dx_dx, float dy_dx, float dx_dy, float dy_dy) const;

 private:
  struct Level {
    Image<std::uint32_t> texels;           ///< Red in the lowest byte.
    float scale_x = 1.0F, scale_y = 1.0F;  ///< From texels of the finest level.
  };
  Eigen::Array4f trilinear(float x, float y, float level) const;
  std::vector<Level> levels_;
};

}  // namespace rastro
