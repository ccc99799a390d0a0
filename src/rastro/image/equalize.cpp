// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/equalize.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rastro {

GrayImage equalized(GrayView image) {
  std::array<std::int64_t, 256> histogram{};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) ++histogram[image.row(y)[x]];
  }
  // The darkest level that occurs maps to 0, so that the whole range is used.
  const auto darkest = std::find_if(histogram.begin(), histogram.end(), [](std::int64_t count) { return count > 0; });
  const std::int64_t below = darkest == histogram.end() ? 0 : *darkest;
  const std::int64_t rest = std::max<std::int64_t>(1, std::int64_t{image.width} * image.height - below);
  std::array<std::uint8_t, 256> level{};
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < 256; ++i) {
    sum += histogram[i];
    level[i] =
        static_cast<std::uint8_t>(std::clamp<std::int64_t>((2 * 255 * (sum - below) + rest) / (2 * rest), 0, 255));
  }
  GrayImage out(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    std::transform(image.row(y), image.row(y) + image.width, out.row(y),
                   [&](std::uint8_t gray) { return level[gray]; });
  }
  return out;
}

Brightness brightness(GrayView image) {
  std::int64_t count = 0, sum = 0, squares = 0;
  for (int y = 0; y < image.height; y += 4) {
    const std::uint8_t* row = image.row(y);
    for (int x = 0; x < image.width; x += 4) {
      ++count;
      sum += row[x];
      squares += row[x] * row[x];
    }
  }
  if (count == 0) return {};
  const double mean = static_cast<double>(sum) / static_cast<double>(count);
  const double variance = static_cast<double>(squares) / static_cast<double>(count) - mean * mean;
  return {mean, std::sqrt(std::max(0.0, variance))};
}

}  // namespace rastro
