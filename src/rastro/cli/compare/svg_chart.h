// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace rastro::cli {

/// One line of a chart.
struct ChartLine {
  std::string name;
  std::vector<double> x, y;
  std::size_t color = 0;  ///< Class of the page: c0, c1, ...
  bool is_reference = false;
  bool has_points = false;
};

struct Chart {
  std::string title, x_label, y_label;
  std::vector<ChartLine> lines;
  bool equal_axes = false;  ///< One unit is as long in both directions.
  bool log_y = false;       ///< Values of 0 and below are left out.
};

/// An inline SVG that takes its colors from the page: classes c0 to c11 for lines, `axis` and `grid`, with a legend
/// below. Lines are thinned to a few hundred points. Empty where nothing is to be drawn.
std::string svg_of(const Chart& chart);

/// Text for HTML and SVG.
std::string escaped(const std::string& text);

/// About five round values over a range.
std::vector<double> round_ticks(double low, double high);

}  // namespace rastro::cli
