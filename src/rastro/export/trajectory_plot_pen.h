// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace rastro {

struct PlotColor {
  std::uint8_t red = 0, green = 0, blue = 0;
};

enum class TextAnchor : std::uint8_t { left, middle, right };

/// Draws on a white sheet; pixels, x to the right, y down.
class PlotPen {
 public:
  virtual ~PlotPen() = default;
  virtual void line(const std::vector<Eigen::Vector2d>& points, PlotColor color, double width) = 0;
  virtual void dot(Eigen::Vector2d center, PlotColor color, double radius) = 0;
  /// `foot`: where the text's base line has its left end, middle or right end.
  virtual void text(const std::string& text, Eigen::Vector2d foot, TextAnchor anchor, double height,
                    PlotColor color) = 0;
  virtual void save(const std::string& file) = 0;
};

/// As the file's ending says: .svg, else PNG.
std::unique_ptr<PlotPen> pen_for(const std::string& file, int width, int height);
std::unique_ptr<PlotPen> svg_pen(int width, int height);
std::unique_ptr<PlotPen> png_pen(int width, int height);

}  // namespace rastro
