// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/pack_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/library_output.h"
#include "rastro/image/image_header.h"
#include "rastro/map/images/packed_depth.h"

namespace rastro {
namespace {

constexpr int jpeg_quality = 92;

/// A view of the pixels, which are not written to.
cv::Mat shared(const std::uint8_t* pixels, int width, int height, int type, std::ptrdiff_t stride) {
  return cv::Mat(height, width, type, const_cast<std::uint8_t*>(pixels), static_cast<std::size_t>(stride));
}

std::vector<std::uint8_t> packed_color(const Frame& frame) {
  std::vector<std::uint8_t> bytes;
  if (frame.color.empty() && frame.image.empty()) return bytes;
  cv::Mat image;
  if (frame.color.empty()) {
    image = shared(frame.image.row(0), frame.image.width(), frame.image.height(), CV_8UC1, frame.image.stride());
  } else {
    const Image<std::uint8_t>& rgb = frame.color.rgb;
    cv::cvtColor(shared(rgb.row(0), frame.color.width(), rgb.height(), CV_8UC3, rgb.stride()), image,
                 cv::COLOR_RGB2BGR);
  }
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality});
  return bytes;
}

cv::Mat decoded(const std::vector<std::uint8_t>& bytes, int flags) {
  if (bytes.empty() || !why_too_large(bytes).empty()) return {};
  const LibraryOutput output;
  try {
    return cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {
    return {};
  }
}

ColorImage unpacked_color(const cv::Mat& bgr) {
  ColorImage color;
  color.rgb = Image<std::uint8_t>(3 * bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y) {
    const std::uint8_t* from = bgr.ptr<std::uint8_t>(y);
    std::uint8_t* to = color.rgb.row(y);
    for (int x = 0; x < bgr.cols; ++x, from += 3, to += 3) to[0] = from[2], to[1] = from[1], to[2] = from[0];
  }
  return color;
}

Error damaged_images(const std::string& where) {
  return {"its images are damaged", where, "'rastro recover' saves what can be read"};
}

}  // namespace

PackedImages pack_images(const Frame& frame) { return {packed_color(frame), pack_depth(frame.depth)}; }

UnpackedImages unpack_images(const PackedImages& images, const std::string& where) {
  const cv::Mat bgr = decoded(images.color, cv::IMREAD_COLOR);
  if (bgr.empty()) throw damaged_images(where);
  // A frame without depth has none anywhere.
  auto depth = images.depth.empty() ? DepthImage(bgr.cols, bgr.rows) : unpack_depth(images.depth);
  if (!depth || depth->width() != bgr.cols || depth->height() != bgr.rows) throw damaged_images(where);
  return {unpacked_color(bgr), std::move(*depth)};
}

GrayImage unpack_gray(const PackedImages& images, int shrink, const std::string& where) {
  const int flags = shrink == 8   ? cv::IMREAD_REDUCED_GRAYSCALE_8
                    : shrink == 4 ? cv::IMREAD_REDUCED_GRAYSCALE_4
                    : shrink == 2 ? cv::IMREAD_REDUCED_GRAYSCALE_2
                                  : cv::IMREAD_GRAYSCALE;
  const cv::Mat pixels = decoded(images.color, flags);
  if (pixels.empty()) throw damaged_images(where);
  GrayImage gray(pixels.cols, pixels.rows);
  for (int y = 0; y < gray.height(); ++y) std::copy_n(pixels.ptr(y), gray.width(), gray.row(y));
  return gray;
}

DepthImage unpack_depth(const PackedImages& images, const std::string& where) {
  if (images.depth.empty()) return unpack_images(images, where).depth;
  auto depth = unpack_depth(images.depth);
  if (!depth) throw damaged_images(where);
  return std::move(*depth);
}

}  // namespace rastro
