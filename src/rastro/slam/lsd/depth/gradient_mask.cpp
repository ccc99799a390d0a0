// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/gradient_mask.h"

#include <cmath>

#include "rastro/slam/lsd/depth/epipolar_kernels.h"

namespace rastro {
namespace {

/// Whether all samples of a window around the pixel may be used.
bool is_window_usable(GrayView usable, int x, int y) {
  constexpr int reach = epipolar_samples / 2;
  for (int v = y - reach; v <= y + reach; ++v)
    for (int u = x - reach; u <= x + reach; ++u)
      if (usable.at(u, v) == 0) return false;
  return true;
}

Image<std::uint8_t> strong_pixels(GrayView image, float min_gradient) {
  constexpr int edge = depth_border - 1;
  // Of twice the central differences, in integers.
  const auto least = static_cast<int>(std::ceil(4.0F * min_gradient * min_gradient));
  Image<std::uint8_t> strong(image.width, image.height);
  for (int y = edge; y < image.height - edge; ++y) {
    const std::uint8_t *above = image.row(y - 1), *row = image.row(y), *below = image.row(y + 1);
    std::uint8_t* to = strong.row(y);
    for (int x = edge; x < image.width - edge; ++x) {
      const int dx = row[x + 1] - row[x - 1], dy = below[x] - above[x];
      to[x] = dx * dx + dy * dy >= least ? 1 : 0;
    }
  }
  return strong;
}

}  // namespace

Image<std::uint8_t> gradient_mask(GrayView image, float min_gradient, GrayView usable) {
  const Image<std::uint8_t> strong = strong_pixels(image, min_gradient);
  Image<std::uint8_t> mask(image.width, image.height);
  for (int y = depth_border; y < image.height - depth_border; ++y) {
    const std::uint8_t *above = strong.row(y - 1), *row = strong.row(y), *below = strong.row(y + 1);
    std::uint8_t* to = mask.row(y);
    for (int x = depth_border; x < image.width - depth_border; ++x)
      to[x] = static_cast<std::uint8_t>(row[x] | row[x - 1] | row[x + 1] | above[x] | below[x]);
    for (int x = depth_border; x < image.width - depth_border && !usable.empty(); ++x)
      if (to[x] != 0 && !is_window_usable(usable, x, y)) to[x] = 0;
  }
  return mask;
}

}  // namespace rastro
