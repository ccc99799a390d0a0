// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <utility>

#include "rastro/base/error.h"

namespace rastro {

/// A non-owning view of rows of pixels; the pixel (x, y) is row(y)[x], its center at integer coordinates.
template <typename T>
struct ImageView {
  T* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  ///< In elements.

  bool empty() const { return width == 0 || height == 0; }
  T* row(int y) const { return data + y * stride; }
  T& at(int x, int y) const { return data[y * stride + x]; }
  operator ImageView<const T>() const { return {data, width, height, stride}; }
};

/// Owning image of one channel. Rows start at multiples of 64 bytes; the padding behind a row may be read but is
/// undefined.
template <typename T>
class Image {
 public:
  Image() = default;
  /// Pixels are zero.
  Image(int width, int height) : width_(width), height_(height) {
    RASTRO_CHECK(width >= 0 && height >= 0, "an image has no negative size");
    constexpr std::size_t per_line = alignment / sizeof(T);
    stride_ = static_cast<std::ptrdiff_t>((static_cast<std::size_t>(width) + per_line - 1) / per_line * per_line);
    // One more line of slack lets SIMD read past the last row's end.
    bytes_ = (static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height) + per_line) * sizeof(T);
    data_ = static_cast<T*>(::operator new (bytes_, std::align_val_t{alignment}));
    std::memset(static_cast<void*>(data_), 0, bytes_);
  }
  Image(const Image& other) : Image(other.width_, other.height_) {
    if (other.data_) std::memcpy(static_cast<void*>(data_), other.data_, bytes_);
  }
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image other) noexcept {
    swap(other);
    return *this;
  }
  ~Image() { ::operator delete (static_cast<void*>(data_), std::align_val_t{alignment}); }

  void swap(Image& other) noexcept {
    std::swap(width_, other.width_);
    std::swap(height_, other.height_);
    std::swap(stride_, other.stride_);
    std::swap(bytes_, other.bytes_);
    std::swap(data_, other.data_);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  std::ptrdiff_t stride() const { return stride_; }
  bool empty() const { return width_ == 0 || height_ == 0; }
  T* row(int y) { return data_ + y * stride_; }
  const T* row(int y) const { return data_ + y * stride_; }
  T& at(int x, int y) { return row(y)[x]; }
  const T& at(int x, int y) const { return row(y)[x]; }

  ImageView<T> view() { return {data_, width_, height_, stride_}; }
  ImageView<const T> view() const { return {data_, width_, height_, stride_}; }
  operator ImageView<const T>() const { return view(); }

 private:
  static constexpr std::size_t alignment = 64;
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::size_t bytes_ = 0;
  T* data_ = nullptr;
};

using GrayImage = Image<std::uint8_t>;
using GrayView = ImageView<const std::uint8_t>;
using DepthImage = Image<float>;  ///< Meters along the optical axis; 0 = no measurement.

/// Interleaved 8-bit RGB (red first), three elements per pixel: width() is three times the image's width in pixels.
struct ColorImage {
  Image<std::uint8_t> rgb;
  int width() const { return rgb.width() / 3; }
  int height() const { return rgb.height(); }
  bool empty() const { return rgb.empty(); }
};

/// Intensity from RGB by ITU-R BT.601 in integers: (4899 R + 9617 G + 1868 B + 8192) >> 14.
GrayImage gray_from_color(const ColorImage& color);

}  // namespace rastro
