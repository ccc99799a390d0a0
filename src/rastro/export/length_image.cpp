// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/length_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "rastro/export/drawing.h"

namespace rastro {
namespace {

constexpr int margin_px = 40, smallest_px = 200, written_px = 900, largest_factor = 6;

cv::Rect part_around(const cv::Size& size, const std::vector<std::array<Eigen::Vector2d, 2>>& lines) {
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const auto& line : lines)
    for (const Eigen::Vector2d& end : line) low = low.cwiseMin(end), high = high.cwiseMax(end);
  const cv::Rect whole({0, 0}, size);
  if (high.x() < low.x()) return whole;
  const double half_x = std::max(0.5 * (high.x() - low.x()) + margin_px, 0.5 * smallest_px);
  const double half_y = std::max(0.5 * (high.y() - low.y()) + margin_px, 0.5 * smallest_px);
  const Eigen::Vector2d center = 0.5 * (low + high);
  const cv::Rect wanted(cvRound(center.x() - half_x), cvRound(center.y() - half_y), cvRound(2.0 * half_x),
                        cvRound(2.0 * half_y));
  const cv::Rect part = wanted & whole;
  return part.empty() ? whole : part;
}

}  // namespace

void write_length_image(const ColorImage& image, const std::vector<std::array<Eigen::Vector2d, 2>>& lines,
                        const std::string& caption, const std::string& file) {
  const cv::Mat rgb(image.height(), image.width(), CV_8UC3, const_cast<std::uint8_t*>(image.rgb.row(0)),
                    static_cast<std::size_t>(image.rgb.stride()));
  std::vector<std::array<Eigen::Vector2d, 2>> drawn;
  const double farthest = image.width() + image.height();
  for (const auto& line : lines) {
    if (std::all_of(line.begin(), line.end(), [&](const auto& end) { return end.norm() < farthest; }))
      drawn.push_back(line);
  }
  const cv::Rect part = part_around(rgb.size(), drawn);
  const int factor = std::clamp(written_px / std::max(1, part.width), 1, largest_factor);
  cv::Mat canvas;
  cv::cvtColor(rgb(part), canvas, cv::COLOR_RGB2BGR);
  cv::resize(canvas, canvas, {}, factor, factor, cv::INTER_NEAREST);
  const auto at = [&](const Eigen::Vector2d& pixel) {
    return cv::Point(cvRound((pixel.x() - part.x + 0.5) * factor), cvRound((pixel.y() - part.y + 0.5) * factor));
  };
  for (const auto& [from, to] : drawn) {
    if ((to - from).norm() < 0.5) {
      cv::drawMarker(canvas, at(from), drawing::magenta, cv::MARKER_CROSS, 24, 1, cv::LINE_AA);
    } else {
      cv::line(canvas, at(from), at(to), drawing::magenta, 1, cv::LINE_AA);
    }
  }
  drawing::save(file, drawing::with_caption(canvas, {{caption, drawing::white}}));
}

}  // namespace rastro
