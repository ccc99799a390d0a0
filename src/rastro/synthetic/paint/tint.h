// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace rastro {

/// Factors of an intensity for red, green and blue: (1, 1, 1) is gray. The luma of the factors (ITU-R BT.601) is 1, so
/// a color image is as bright as the gray one.
struct Tint {
  float red = 1.0F, green = 1.0F, blue = 1.0F;
  bool operator==(const Tint&) const = default;
};

/// A color in 0..255 per channel.
struct Color {
  float red = 128.0F, green = 128.0F, blue = 128.0F;

  /// The intensity of the color.
  float tone() const { return 0.299F * red + 0.587F * green + 0.114F * blue; }
  Tint tint() const {
    const float gray = tone();
    return gray > 0.0F ? Tint{red / gray, green / gray, blue / gray} : Tint{};
  }
};

}  // namespace rastro
