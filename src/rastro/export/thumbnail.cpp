// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/thumbnail.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace rastro {
namespace {

std::string small_jpeg(const cv::Mat& image, int side_px) {
  if (image.empty()) return "";
  cv::Mat small = image;
  const double factor = static_cast<double>(side_px) / std::max(image.cols, image.rows);
  if (factor < 1.0) cv::resize(image, small, {}, factor, factor, cv::INTER_AREA);
  std::vector<std::uint8_t> bytes;
  constexpr int quality = 80;
  cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return "data:image/jpeg;base64," + as_base64({bytes.begin(), bytes.end()});
}

/// OpenCV's view of pixels that it does not change.
cv::Mat view_of(const Image<std::uint8_t>& image, int channels) {
  auto* data = const_cast<std::uint8_t*>(image.row(0));
  return {image.height(), image.width() / channels, CV_8UC(channels), data, static_cast<std::size_t>(image.stride())};
}

cv::Mat without_transparency(const cv::Mat& image) {
  if (image.channels() != 4) return image;
  cv::Mat opaque(image.size(), CV_8UC3);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const auto& pixel = image.at<cv::Vec4b>(y, x);
      for (int k = 0; k < 3; ++k)
        opaque.at<cv::Vec3b>(y, x)[k] =
            static_cast<std::uint8_t>((pixel[k] * pixel[3] + 255 * (255 - pixel[3]) + 127) / 255);
    }
  }
  return opaque;
}

}  // namespace

std::string as_base64(const std::string& bytes) {
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    std::uint32_t three = 0;
    for (std::size_t j = 0; j < 3; ++j)
      three = three << 8U | (k + j < bytes.size() ? static_cast<std::uint8_t>(bytes[k + j]) : 0U);
    for (std::size_t j = 0; j < 4; ++j) text += k + j > bytes.size() ? '=' : letters[three >> (18U - 6U * j) & 63U];
  }
  return text;
}

std::string thumbnail_of(const std::string& image_file, int side_px) {
  try {
    const cv::Mat image = cv::imread(image_file, cv::IMREAD_UNCHANGED);
    return image.depth() == CV_8U ? small_jpeg(without_transparency(image), side_px) : "";
  } catch (const cv::Exception&) {
    return "";
  }
}

std::string thumbnail_of(const Frame& frame, int side_px) {
  if (frame.color.empty()) return frame.image.empty() ? "" : small_jpeg(view_of(frame.image, 1), side_px);
  cv::Mat in_order_of_opencv;
  cv::cvtColor(view_of(frame.color.rgb, 3), in_order_of_opencv, cv::COLOR_RGB2BGR);
  return small_jpeg(in_order_of_opencv, side_px);
}

}  // namespace rastro
