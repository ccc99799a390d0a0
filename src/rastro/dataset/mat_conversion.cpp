// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/mat_conversion.h"

#include <fmt/format.h>

#include <algorithm>

namespace rastro {
namespace {

/// 16 bit to 8 bit, rounded, so that 65535 becomes 255.
unsigned to_8_bit(std::uint8_t value) { return value; }
unsigned to_8_bit(std::uint16_t value) { return (value * 255u + 32767u) / 65535u; }

template <typename T>
void convert_gray(const cv::Mat& mat, GrayImage& gray) {
  const int step = mat.channels();
  for (int y = 0; y < mat.rows; ++y) {
    const T* from = mat.ptr<T>(y);
    std::uint8_t* to = gray.row(y);
    for (int x = 0; x < mat.cols; ++x) to[x] = static_cast<std::uint8_t>(to_8_bit(from[x * step]));
  }
}

/// The weights of gray_from_color, straight from BGR so that no color image is made where none is wanted.
template <typename T>
void convert_color(const cv::Mat& mat, GrayImage& gray, ColorImage* color) {
  const int step = mat.channels();
  for (int y = 0; y < mat.rows; ++y) {
    const T* from = mat.ptr<T>(y);
    std::uint8_t* to = gray.row(y);
    std::uint8_t* rgb = color ? color->rgb.row(y) : nullptr;
    for (int x = 0; x < mat.cols; ++x, from += step) {
      const unsigned b = to_8_bit(from[0]), g = to_8_bit(from[1]), r = to_8_bit(from[2]);
      to[x] = static_cast<std::uint8_t>((4899u * r + 9617u * g + 1868u * b + 8192u) >> 14);
      if (!rgb) continue;
      *rgb++ = static_cast<std::uint8_t>(r);
      *rgb++ = static_cast<std::uint8_t>(g);
      *rgb++ = static_cast<std::uint8_t>(b);
    }
  }
}

void repeat_gray(const GrayImage& gray, ColorImage& color) {
  for (int y = 0; y < gray.height(); ++y) {
    const std::uint8_t* from = gray.row(y);
    std::uint8_t* to = color.rgb.row(y);
    for (int x = 0; x < gray.width(); ++x, to += 3) std::fill_n(to, 3, from[x]);
  }
}

}  // namespace

std::string convert(const cv::Mat& mat, bool want_color, DecodedImage& image) {
  if (mat.depth() != CV_8U && mat.depth() != CV_16U) return "has neither 8 nor 16 bit a channel";
  if (mat.channels() < 1 || mat.channels() > 4) return fmt::format("has {} channels", mat.channels());
  image.gray = GrayImage(mat.cols, mat.rows);
  if (want_color) image.color.rgb = Image<std::uint8_t>(mat.cols * 3, mat.rows);
  ColorImage* color = want_color ? &image.color : nullptr;
  const bool wide = mat.depth() == CV_16U;
  if (mat.channels() >= 3) {
    wide ? convert_color<std::uint16_t>(mat, image.gray, color) : convert_color<std::uint8_t>(mat, image.gray, color);
    return "";
  }
  wide ? convert_gray<std::uint16_t>(mat, image.gray) : convert_gray<std::uint8_t>(mat, image.gray);
  if (color) repeat_gray(image.gray, *color);
  return "";
}

}  // namespace rastro
