// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "rastro/base/random.h"
#include "rastro/image/padded_image.h"

namespace rastro::testing {

/// Image noise, every pixel drawn independently.
inline GrayImage noise_image(int width, int height, std::uint64_t seed) {
  Random random(seed);
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at(x, y) = static_cast<std::uint8_t>(random.below(256));
  }
  return image;
}

/// A smooth image that can be sampled anywhere: waves of several lengths and directions, shifted by (dx, dy).
inline GrayImage wave_image(int width, int height, double dx, double dy) {
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = x - dx, v = y - dy;
      const double value = 128.0 + 30.0 * std::sin(0.21 * u + 0.05 * v) + 25.0 * std::sin(0.17 * v - 0.08 * u + 1.0) +
                           20.0 * std::sin(0.45 * u + 0.31 * v + 2.0) + 15.0 * std::sin(0.53 * v - 0.37 * u + 0.5) +
                           20.0 * std::sin(0.031 * u * 1.7 + 0.043 * v + 0.2);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(value));
    }
  }
  return image;
}

inline PaddedImage padded(const GrayImage& image, int padding) {
  PaddedImage result;
  result.reset(image.width(), image.height(), padding);
  for (int y = 0; y < image.height(); ++y)
    std::memcpy(result.row(y), image.row(y), static_cast<std::size_t>(image.width()));
  result.fill_padding();
  return result;
}

}  // namespace rastro::testing
