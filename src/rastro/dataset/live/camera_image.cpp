// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/camera_image.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/base/error.h"
#include "rastro/dataset/mat_conversion.h"

namespace rastro {
namespace {

void set_images(const cv::Mat& mat, bool want_color, Frame& frame) {
  DecodedImage image;
  const std::string reason = convert(mat, want_color, image);
  if (!reason.empty()) throw Error("the image " + reason, "camera", "");
  frame.image = std::move(image.gray);
  frame.color = std::move(image.color);
}

cv::Mat mat_of(const unsigned char* bytes, int width, int height, std::size_t stride, int type) {
  return {height, width, type, const_cast<unsigned char*>(bytes), stride};
}

}  // namespace

void decode_jpeg(std::span<const unsigned char> file, bool want_color, Frame& frame) {
  cv::Mat mat;
  try {
    const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8U, const_cast<unsigned char*>(file.data()));
    cv::imdecode(bytes, (want_color ? cv::IMREAD_COLOR : cv::IMREAD_GRAYSCALE) | cv::IMREAD_IGNORE_ORIENTATION, &mat);
  } catch (const cv::Exception&) {
    mat.release();
  }
  if (mat.empty()) throw Error("an image cannot be decoded", "JPEG", "it is damaged");
  set_images(mat, want_color, frame);
}

void convert_y4m(const Y4mHeader& header, std::span<const unsigned char> planes, bool want_color, Frame& frame) {
  const auto width = static_cast<std::size_t>(header.width);
  const cv::Mat luma = mat_of(planes.data(), header.width, header.height, width, CV_8U);
  if (!want_color || header.chroma_x == 0) return set_images(luma, want_color, frame);
  const int chroma_width = static_cast<int>(header.chroma_width());
  const int chroma_height = static_cast<int>(header.chroma_height());
  const std::size_t chroma_bytes = header.chroma_width() * header.chroma_height();
  cv::Mat channels[3] = {luma, {}, {}};
  for (std::size_t k = 0; k < 2; ++k) {
    const unsigned char* plane = planes.data() + header.luma_bytes() + k * chroma_bytes;
    // OpenCV's order is Y, Cr, Cb.
    cv::resize(mat_of(plane, chroma_width, chroma_height, header.chroma_width(), CV_8U), channels[2 - k], luma.size(),
               0, 0, cv::INTER_LINEAR);
  }
  cv::Mat merged, color;
  cv::merge(channels, 3, merged);
  if (!header.full_range) {
    // Luma 16..235, chroma 16..240 (ITU-R BT.601), to the full range that OpenCV converts.
    merged.convertTo(merged, CV_32F);
    cv::subtract(merged, cv::Scalar(16, 128, 128), merged);
    cv::multiply(merged, cv::Scalar(255.0 / 219.0, 255.0 / 224.0, 255.0 / 224.0), merged);
    cv::add(merged, cv::Scalar(0, 128, 128), merged);
    merged.convertTo(merged, CV_8U);
  }
  cv::cvtColor(merged, color, cv::COLOR_YCrCb2BGR);
  set_images(color, true, frame);
}

void convert_yuyv(const unsigned char* bytes, int width, int height, std::size_t stride, bool want_color,
                  Frame& frame) {
  if (want_color) {
    cv::Mat color;
    cv::cvtColor(mat_of(bytes, width, height, stride, CV_8UC2), color, cv::COLOR_YUV2BGR_YUYV);
    return set_images(color, true, frame);
  }
  frame.image = GrayImage(width, height);
  for (int y = 0; y < height; ++y) {
    const unsigned char* from = bytes + static_cast<std::size_t>(y) * stride;
    std::uint8_t* to = frame.image.row(y);
    for (int x = 0; x < width; ++x) to[x] = from[2 * x];
  }
}

void convert_grey(const unsigned char* bytes, int width, int height, std::size_t stride, bool want_color,
                  Frame& frame) {
  set_images(mat_of(bytes, width, height, stride, CV_8U), want_color, frame);
}

void convert_rgb(const unsigned char* bytes, int width, int height, std::size_t stride, bool want_color, Frame& frame) {
  cv::Mat color;
  cv::cvtColor(mat_of(bytes, width, height, stride, CV_8UC3), color, cv::COLOR_RGB2BGR);
  set_images(color, want_color, frame);
}

}  // namespace rastro
