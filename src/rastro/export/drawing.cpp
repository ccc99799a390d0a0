// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"

namespace rastro::drawing {
namespace {

constexpr int readable_width_px = 600;
constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
constexpr int caption_height_px = 26;
constexpr int caption_margin_px = 8;
constexpr double caption_size = 0.5;
constexpr double id_size = 0.36;

int width_of(const std::string& text, double size) {
  int baseline = 0;
  return cv::getTextSize(text, font, size, 1, &baseline).width;
}

std::vector<Piece> counts_of(const TrackFrame& frame) {
  std::vector<Piece> pieces = {{fmt::format("frame {}   ", frame.index), white},
                               {fmt::format("{} followed   ", frame.tracked), white},
                               {fmt::format("{} re-identified   ", frame.reidentified), green},
                               {fmt::format("{} new   {} lost", frame.fresh, frame.lost), white}};
  if (frame.health != TrackHealth::good) pieces.push_back({fmt::format("   {}", name_of(frame.health)), magenta});
  return pieces;
}

}  // namespace

cv::Point2f Canvas::at(const Eigen::Vector2f& pixel) const {
  // Pixel centers are at integers in both images.
  const float factor = static_cast<float>(scale);
  return {(pixel.x() + 0.5F) * factor - 0.5F, (pixel.y() + 0.5F) * factor - 0.5F};
}

int scale_for(int width) {
  return width > 0 && width < readable_width_px ? (readable_width_px + width - 1) / width : 1;
}

Canvas canvas_of(GrayView image) {
  // cv::Mat has no const form; it is only read.
  const cv::Mat gray(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data),
                     static_cast<std::size_t>(image.stride));
  Canvas canvas;
  canvas.scale = std::min(scale_for(image.width), 8);
  cv::cvtColor(gray, canvas.image, cv::COLOR_GRAY2BGR);
  if (canvas.scale > 1) {
    cv::resize(canvas.image, canvas.image, {}, canvas.scale, canvas.scale, cv::INTER_NEAREST);
  }
  return canvas;
}

void put_text(cv::Mat& image, const std::string& text, cv::Point2f lower_left, const cv::Scalar& color, double size) {
  int baseline = 0;
  const cv::Size extent = cv::getTextSize(text, font, size, 1, &baseline);
  const int x = std::clamp(cvRound(lower_left.x), 1, std::max(1, image.cols - extent.width - 2));
  const int y = std::clamp(cvRound(lower_left.y), extent.height + 1, std::max(extent.height + 1, image.rows - 3));
  cv::putText(image, text, {x, y}, font, size, cv::Scalar(0, 0, 0), 3, cv::LINE_AA);
  cv::putText(image, text, {x, y}, font, size, color, 1, cv::LINE_AA);
}

cv::Mat caption_strip(int width, const std::vector<Piece>& pieces) {
  int needed = 2 * caption_margin_px;
  for (const Piece& piece : pieces) needed += width_of(piece.text, caption_size);
  // A caption wider than the image is written smaller rather than cut.
  const double size = caption_size * std::min(1.0, static_cast<double>(width) / needed);
  cv::Mat strip(caption_height_px, width, CV_8UC3, cv::Scalar(32, 32, 32));
  int x = caption_margin_px;
  for (const Piece& piece : pieces) {
    cv::putText(strip, piece.text, {x, caption_height_px - 8}, font, size, piece.color, 1, cv::LINE_AA);
    x += width_of(piece.text, size);
  }
  return strip;
}

cv::Mat with_caption(const cv::Mat& image, const std::vector<Piece>& pieces) {
  cv::Mat whole;
  cv::vconcat(caption_strip(image.cols, pieces), image, whole);
  return whole;
}

cv::Mat overlay(const TrackFrame& frame, GrayView image) {
  Canvas canvas = canvas_of(image);
  for (const TrackedFeature& feature : frame.features) {
    cv::circle(canvas.image, canvas.at(feature.pixel), 3, red, cv::FILLED, cv::LINE_AA);
  }
  for (const TrackedFeature& feature : frame.features) {
    const cv::Point2f beside = canvas.at(feature.pixel) + cv::Point2f(5.0F, -3.0F);
    put_text(canvas.image, fmt::format("{}", feature.id), beside, green, id_size);
  }
  return with_caption(canvas.image, counts_of(frame));
}

void save(const std::string& path, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  const bool photograph = std::filesystem::path(path).extension() == ".jpg";
  // Level 1 is four times as fast as the best one and a tenth larger.
  const std::vector<int> settings =
      photograph ? std::vector<int>{cv::IMWRITE_JPEG_QUALITY, 92} : std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 1};
  if (!cv::imencode(photograph ? ".jpg" : ".png", image, bytes, settings)) {
    throw Error("the image cannot be encoded", path, "check the size of the images");
  }
  write_whole_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace rastro::drawing
