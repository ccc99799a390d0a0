// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/image.h"

namespace rastro {

GreyImage grey_from_colour(const ColourImage& colour) {
  GreyImage grey(colour.width(), colour.height());
  for (int y = 0; y < grey.height(); ++y) {
    const std::uint8_t* rgb = colour.rgb.row(y);
    std::uint8_t* out = grey.row(y);
    for (int x = 0; x < grey.width(); ++x, rgb += 3) {
      out[x] = static_cast<std::uint8_t>((4899 * rgb[0] + 9617 * rgb[1] + 1868 * rgb[2] + 8192) >> 14);
    }
  }
  return grey;
}

}  // namespace rastro
