// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/small_image.h"

#include <algorithm>

#include "rastro/map/images/pack_images.h"

namespace rastro::detail {
namespace {

/// Means over squares of `factor` x `factor` pixels of `channels` numbers each.
Image<std::uint8_t> reduced(const Image<std::uint8_t>& image, int channels, int factor) {
  Image<std::uint8_t> small(image.width() / channels / factor * channels, image.height() / factor);
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) {
      int sum = factor * factor / 2;
      for (int row = 0; row < factor; ++row)
        for (int column = 0; column < factor; ++column)
          sum += image.at(channels * (x / channels * factor + column) + x % channels, y * factor + row);
      small.at(x, y) = static_cast<std::uint8_t>(sum / (factor * factor));
    }
  }
  return small;
}

}  // namespace

SceneImage small_image(const Frame& frame, int longest_px) {
  Frame small;
  const auto factor = [longest_px](int width, int height) { return 1 + (std::max(width, height) - 1) / longest_px; };
  if (!frame.color.empty()) {
    small.color.rgb = reduced(frame.color.rgb, 3, factor(frame.color.width(), frame.color.height()));
    return {0, small.color.width(), small.color.height(), pack_images(small).color};
  }
  small.image = reduced(frame.image, 1, factor(frame.image.width(), frame.image.height()));
  return {0, small.image.width(), small.image.height(), pack_images(small).color};
}

}  // namespace rastro::detail
