// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace rastro {

/// What a grey level is multiplied with for red, green and blue: (1, 1, 1) is grey. Of the grey that the three give
/// together (ITU-R BT.601) it is 1, so that a picture in colour is as light as the grey one.
struct Tint {
  float red = 1.0F, green = 1.0F, blue = 1.0F;
  bool operator==(const Tint&) const = default;
};

/// A colour as painters think of it: 0..255 each.
struct Colour {
  float red = 128.0F, green = 128.0F, blue = 128.0F;

  /// The grey level of the colour.
  float tone() const { return 0.299F * red + 0.587F * green + 0.114F * blue; }
  Tint tint() const {
    const float grey = tone();
    return grey > 0.0F ? Tint{red / grey, green / grey, blue / grey} : Tint{};
  }
};

}  // namespace rastro
