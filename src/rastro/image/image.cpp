// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/image.h"

namespace rastro {

GrayImage gray_from_color(const ColorImage& color) {
  GrayImage gray(color.width(), color.height());
  for (int y = 0; y < gray.height(); ++y) {
    const std::uint8_t* rgb = color.rgb.row(y);
    std::uint8_t* out = gray.row(y);
    for (int x = 0; x < gray.width(); ++x, rgb += 3) {
      out[x] = static_cast<std::uint8_t>((4899 * rgb[0] + 9617 * rgb[1] + 1868 * rgb[2] + 8192) >> 14);
    }
  }
  return gray;
}

}  // namespace rastro
