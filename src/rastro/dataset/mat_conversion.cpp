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
void convert_grey(const cv::Mat& picture, GreyImage& grey) {
  const int step = picture.channels();
  for (int y = 0; y < picture.rows; ++y) {
    const T* from = picture.ptr<T>(y);
    std::uint8_t* to = grey.row(y);
    for (int x = 0; x < picture.cols; ++x) to[x] = static_cast<std::uint8_t>(to_8_bit(from[x * step]));
  }
}

/// The weights of grey_from_colour, straight from BGR so that no colour image is made where none is wanted.
template <typename T>
void convert_colour(const cv::Mat& picture, GreyImage& grey, ColourImage* colour) {
  const int step = picture.channels();
  for (int y = 0; y < picture.rows; ++y) {
    const T* from = picture.ptr<T>(y);
    std::uint8_t* to = grey.row(y);
    std::uint8_t* rgb = colour ? colour->rgb.row(y) : nullptr;
    for (int x = 0; x < picture.cols; ++x, from += step) {
      const unsigned b = to_8_bit(from[0]), g = to_8_bit(from[1]), r = to_8_bit(from[2]);
      to[x] = static_cast<std::uint8_t>((4899u * r + 9617u * g + 1868u * b + 8192u) >> 14);
      if (!rgb) continue;
      *rgb++ = static_cast<std::uint8_t>(r);
      *rgb++ = static_cast<std::uint8_t>(g);
      *rgb++ = static_cast<std::uint8_t>(b);
    }
  }
}

void repeat_grey(const GreyImage& grey, ColourImage& colour) {
  for (int y = 0; y < grey.height(); ++y) {
    const std::uint8_t* from = grey.row(y);
    std::uint8_t* to = colour.rgb.row(y);
    for (int x = 0; x < grey.width(); ++x, to += 3) std::fill_n(to, 3, from[x]);
  }
}

}  // namespace

std::string convert(const cv::Mat& picture, bool want_colour, DecodedImage& image) {
  if (picture.depth() != CV_8U && picture.depth() != CV_16U) return "has neither 8 nor 16 bit a channel";
  if (picture.channels() < 1 || picture.channels() > 4) return fmt::format("has {} channels", picture.channels());
  image.grey = GreyImage(picture.cols, picture.rows);
  if (want_colour) image.colour.rgb = Image<std::uint8_t>(picture.cols * 3, picture.rows);
  ColourImage* colour = want_colour ? &image.colour : nullptr;
  const bool wide = picture.depth() == CV_16U;
  if (picture.channels() >= 3) {
    wide ? convert_colour<std::uint16_t>(picture, image.grey, colour)
         : convert_colour<std::uint8_t>(picture, image.grey, colour);
    return "";
  }
  wide ? convert_grey<std::uint16_t>(picture, image.grey) : convert_grey<std::uint8_t>(picture, image.grey);
  if (colour) repeat_grey(image.grey, *colour);
  return "";
}

}  // namespace rastro
