// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/image.h"

namespace rastro {

/// A gray image whose rows and columns may be read up to `padding` pixels outside. There it is mirrored about its
/// border pixel (the border pixel itself not repeated) if the image is larger than the padding; otherwise the border is
/// repeated.
class PaddedImage {
 public:
  /// Sets the size; keeps the memory if the size is unchanged. Pixels are undefined until written.
  void reset(int width, int height, int padding);
  /// Mirrors the interior into the padding; call after writing the interior.
  void fill_padding();

  int width() const { return width_; }
  int height() const { return height_; }
  int padding() const { return padding_; }
  std::ptrdiff_t stride() const { return storage_.stride(); }
  std::uint8_t* row(int y) { return storage_.row(y + padding_) + padding_; }
  const std::uint8_t* row(int y) const { return storage_.row(y + padding_) + padding_; }
  GrayView view() const { return {row(0), width_, height_, storage_.stride()}; }

 private:
  GrayImage storage_;
  int width_ = 0;
  int height_ = 0;
  int padding_ = 0;
};

}  // namespace rastro
