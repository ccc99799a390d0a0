// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/pack_images.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/base/error.h"
#include "rastro/base/library_output.h"
#include "rastro/image/image_header.h"

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

std::vector<std::uint8_t> packed_depth(const DepthImage& depth) {
  std::vector<std::uint8_t> bytes;
  if (depth.empty()) return bytes;
  cv::Mat image(depth.height(), depth.width(), CV_16U);
  for (int y = 0; y < depth.height(); ++y) {
    const float* from = depth.row(y);
    auto* to = image.ptr<std::uint16_t>(y);
    for (int x = 0; x < depth.width(); ++x) {
      const double units = std::round(static_cast<double>(from[x]) * packed_depth_units_per_meter);
      to[x] = units > 0.0 && units <= 65535.0 ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
    }
  }
  cv::imencode(".png", image, bytes,
               {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_RLE});
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

DepthImage unpacked_depth(const cv::Mat& units) {
  DepthImage depth(units.cols, units.rows);
  for (int y = 0; y < units.rows; ++y) {
    const auto* from = units.ptr<std::uint16_t>(y);
    for (int x = 0; x < units.cols; ++x)
      depth.at(x, y) = static_cast<float>(static_cast<double>(from[x]) / packed_depth_units_per_meter);
  }
  return depth;
}

Error damaged_images(const std::string& where) {
  return {"its images are damaged", where, "'rastro recover' saves what can be read"};
}

}  // namespace

PackedImages pack_images(const Frame& frame) { return {packed_color(frame), packed_depth(frame.depth)}; }

UnpackedImages unpack_images(const PackedImages& images, const std::string& where) {
  const cv::Mat bgr = decoded(images.color, cv::IMREAD_COLOR);
  cv::Mat units = decoded(images.depth, cv::IMREAD_UNCHANGED);
  if (images.depth.empty()) units = cv::Mat::zeros(bgr.size(), CV_16UC1);  // a frame without depth
  if (bgr.empty() || units.empty() || units.type() != CV_16UC1 || bgr.size() != units.size())
    throw damaged_images(where);
  return {unpacked_color(bgr), unpacked_depth(units)};
}

DepthImage unpack_depth(const PackedImages& images, const std::string& where) {
  if (images.depth.empty()) return unpack_images(images, where).depth;
  const cv::Mat units = decoded(images.depth, cv::IMREAD_UNCHANGED);
  if (units.empty() || units.type() != CV_16UC1) throw damaged_images(where);
  return unpacked_depth(units);
}

}  // namespace rastro
