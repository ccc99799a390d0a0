// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/padded_image.h"

#include <algorithm>

namespace rastro {
namespace {

int mirrored(int i, int size) {
  if (i < 0) i = -i;
  if (i >= size) i = 2 * (size - 1) - i;
  return std::clamp(i, 0, size - 1);
}

}  // namespace

void PaddedImage::reset(int width, int height, int padding) {
  if (width == width_ && height == height_ && padding == padding_) return;
  storage_ = GrayImage(width + 2 * padding, height + 2 * padding);
  width_ = width;
  height_ = height;
  padding_ = padding;
}

void PaddedImage::fill_padding() {
  for (int y = 0; y < height_; ++y) {
    std::uint8_t* pixels = row(y);
    if (padding_ < width_) {
      std::reverse_copy(pixels + 1, pixels + 1 + padding_, pixels - padding_);
      std::reverse_copy(pixels + width_ - 1 - padding_, pixels + width_ - 1, pixels + width_);
      continue;
    }
    for (int x = 1; x <= padding_; ++x) {
      pixels[-x] = pixels[mirrored(-x, width_)];
      pixels[width_ - 1 + x] = pixels[mirrored(width_ - 1 + x, width_)];
    }
  }
  const auto line_bytes = static_cast<std::size_t>(width_ + 2 * padding_);
  for (int y = 1; y <= padding_; ++y) {
    std::memcpy(row(-y) - padding_, row(mirrored(-y, height_)) - padding_, line_bytes);
    std::memcpy(row(height_ - 1 + y) - padding_, row(mirrored(height_ - 1 + y, height_)) - padding_, line_bytes);
  }
}

}  // namespace rastro
