// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "rastro/base/error.h"
#include "rastro/calibration/report.h"

namespace rastro {
namespace {

constexpr double residual_scale = 50.0;
constexpr int text_height = 28;

void write_png(const cv::Mat& image, const std::string& path) {
  bool written = false;
  try {
    written = cv::imwrite(path, image);
  } catch (const cv::Exception&) {
  }
  if (!written) throw Error("cannot be written", path, "is there space, and may you write there?");
}

void write_words(cv::Mat& image, const std::string& words, int y) {
  cv::putText(image, words, {6, y}, cv::FONT_HERSHEY_SIMPLEX, 0.5, {40, 40, 40}, 1, cv::LINE_AA);
}

cv::Scalar color_at(double share) {
  const cv::Mat value(1, 1, CV_8UC1, cv::Scalar(std::clamp(share, 0.0, 1.0) * 255.0));
  cv::Mat color;
  cv::applyColorMap(value, color, cv::COLORMAP_VIRIDIS);
  const auto pixel = color.at<cv::Vec3b>(0, 0);
  return {static_cast<double>(pixel[0]), static_cast<double>(pixel[1]), static_cast<double>(pixel[2])};
}

}  // namespace

void write_residual_image(const CalibrationReport& report, std::size_t camera, const std::string& path) {
  const CalibrationInput& input = report.input;
  cv::Mat image(input.height + text_height, input.width, CV_8UC3, cv::Scalar(255, 255, 255));
  cv::rectangle(image, {0, 0, input.width, input.height}, {200, 200, 200});
  const BoardSolution& solution = report.calibration.solution;
  for (std::size_t v = 0; v < solution.problem.views.size(); ++v) {
    const BoardView& view = solution.problem.views[v];
    if (static_cast<std::size_t>(view.camera) != camera) continue;
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      const Eigen::Vector2d end = view.pixels[i] + residual_scale * solution.residuals[v][i];
      const cv::Point at(static_cast<int>(std::lround(view.pixels[i].x())),
                         static_cast<int>(std::lround(view.pixels[i].y())));
      cv::line(image, at, {static_cast<int>(std::lround(end.x())), static_cast<int>(std::lround(end.y()))},
               {60, 60, 220}, 1, cv::LINE_AA);
      cv::circle(image, at, 1, {60, 120, 40}, cv::FILLED);
    }
  }
  write_words(image, fmt::format("residuals, {:g} times as long; {:.3f} px RMS", residual_scale, solution.rms_px()),
              input.height + 18);
  write_png(image, path);
}

void write_uncertainty_image(const CalibrationReport& report, std::size_t camera, const std::string& path) {
  const ImageMap& map = report.trust[camera].uncertainty;
  const int width = report.input.width, height = report.input.height;
  double largest = 0.0;
  for (const double value : map.values)
    if (std::isfinite(value)) largest = std::max(largest, value);
  const double full = std::clamp(largest, 0.01, 2.0);
  cv::Mat small(map.rows, map.columns, CV_8UC1);
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column) {
      const double value = map.at(column, row);
      small.at<std::uint8_t>(row, column) =
          static_cast<std::uint8_t>(std::isfinite(value) ? std::clamp(value / full, 0.0, 1.0) * 255.0 : 255.0);
    }
  cv::Mat gray, colored;
  cv::resize(small, gray, {width, height}, 0.0, 0.0, cv::INTER_LINEAR);
  cv::applyColorMap(gray, colored, cv::COLORMAP_VIRIDIS);
  cv::Mat image(height + 2 * text_height, width, CV_8UC3, cv::Scalar(255, 255, 255));
  colored.copyTo(image(cv::Rect(0, 0, width, height)));
  for (const BoardView& view : report.calibration.solution.problem.views)
    if (static_cast<std::size_t>(view.camera) == camera)
      for (const Eigen::Vector2d& pixel : view.pixels)
        cv::circle(image, {static_cast<int>(pixel.x()), static_cast<int>(pixel.y())}, 1, {255, 255, 255}, cv::FILLED);
  for (int x = 0; x < width; ++x)
    cv::line(image, {x, height + 4}, {x, height + 16}, color_at(static_cast<double>(x) / width));
  write_words(image,
              fmt::format("0 to {:.2f} px: standard deviation of where a far point projects; median {:.3f}", full,
                          report.trust[camera].uncertainty_median_px),
              height + 40);
  write_png(image, path);
}

}  // namespace rastro
