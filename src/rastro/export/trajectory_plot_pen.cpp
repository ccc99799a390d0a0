// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/trajectory_plot_pen.h"

#include <fmt/format.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "rastro/base/append_file.h"
#include "rastro/export/drawing.h"

namespace rastro {
namespace {

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += c;
  }
  return result;
}

std::string hex(PlotColor color) { return fmt::format("#{:02x}{:02x}{:02x}", color.red, color.green, color.blue); }

class SvgPen : public PlotPen {
 public:
  SvgPen(int width, int height)
      : text_(fmt::format(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
            "font-family=\"sans-serif\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
            width, height)) {}

  void line(const std::vector<Eigen::Vector2d>& points, PlotColor color, double width) override {
    if (points.empty()) return;
    text_ += fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\" points=\"", hex(color), width);
    for (const Eigen::Vector2d& point : points) text_ += fmt::format("{:.1f},{:.1f} ", point.x(), point.y());
    text_.back() = '"';
    text_ += "/>\n";
  }

  void dot(Eigen::Vector2d center, PlotColor color, double radius) override {
    text_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\" fill=\"{}\"/>\n", center.x(), center.y(),
                         radius, hex(color));
  }

  void text(const std::string& text, Eigen::Vector2d foot, TextAnchor anchor, double height, PlotColor color) override {
    constexpr const char* anchors[] = {"start", "middle", "end"};
    text_ +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:g}\" text-anchor=\"{}\" fill=\"{}\">{}</text>\n",
                    foot.x(), foot.y(), height, anchors[static_cast<std::size_t>(anchor)], hex(color), escaped(text));
  }

  void save(const std::string& file) override { write_whole_file(file, text_ + "</svg>\n"); }

 private:
  std::string text_;
};

class PngPen : public PlotPen {
 public:
  PngPen(int width, int height) : image_(height, width, CV_8UC3, cv::Scalar(255, 255, 255)) {}

  void line(const std::vector<Eigen::Vector2d>& points, PlotColor color, double width) override {
    std::vector<cv::Point> vertices;
    for (const Eigen::Vector2d& point : points)
      vertices.emplace_back(cvRound(point.x() * fraction_units), cvRound(point.y() * fraction_units));
    cv::polylines(image_, vertices, false, bgr(color), std::max(1, cvRound(width)), cv::LINE_AA, fraction_bits);
  }

  void dot(Eigen::Vector2d center, PlotColor color, double radius) override {
    const cv::Point at(cvRound(center.x() * fraction_units), cvRound(center.y() * fraction_units));
    cv::circle(image_, at, cvRound(radius * fraction_units), bgr(color), cv::FILLED, cv::LINE_AA, fraction_bits);
  }

  void text(const std::string& text, Eigen::Vector2d foot, TextAnchor anchor, double height, PlotColor color) override {
    const double size = height / font_height;
    int below = 0;
    const int width = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &below).width;
    const double shift = anchor == TextAnchor::left ? 0.0 : anchor == TextAnchor::middle ? 0.5 : 1.0;
    cv::putText(image_, text, {cvRound(foot.x() - shift * width), cvRound(foot.y())}, cv::FONT_HERSHEY_SIMPLEX, size,
                bgr(color), 1, cv::LINE_AA);
  }

  void save(const std::string& file) override { drawing::save(file, image_); }

 private:
  static constexpr int fraction_bits = 4;
  static constexpr double fraction_units = 1 << fraction_bits;
  static constexpr double font_height = 30.0;  ///< Of OpenCV's letters at size 1, with what hangs below the line.
  static cv::Scalar bgr(PlotColor color) { return {double(color.blue), double(color.green), double(color.red)}; }

  cv::Mat image_;
};

}  // namespace

std::unique_ptr<PlotPen> pen_for(const std::string& file, int width, int height) {
  return std::filesystem::path(file).extension() == ".svg" ? svg_pen(width, height) : png_pen(width, height);
}
std::unique_ptr<PlotPen> svg_pen(int width, int height) { return std::make_unique<SvgPen>(width, height); }
std::unique_ptr<PlotPen> png_pen(int width, int height) { return std::make_unique<PngPen>(width, height); }

}  // namespace rastro
