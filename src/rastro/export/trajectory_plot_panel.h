// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "rastro/export/trajectory_plot_pen.h"

namespace rastro {

/// One curve in the units of the axes.
struct PlotCurve {
  std::vector<Eigen::Vector2d> points;
  PlotColor color;
};

/// Points of one color in the units of the axes.
struct PlotDots {
  std::vector<Eigen::Vector2d> points;
  PlotColor color;
  double radius = 2.0;  ///< Pixels.
};

/// A frame with axes, curves and dots in it.
struct PlotPanel {
  Eigen::Vector2d corner, size;  ///< Of the frame, pixels; the numbers of the axes stand left of it and below.
  std::string title;             ///< Above the frame.
  std::string x_label;           ///< Below it; empty: no numbers there either.
  bool equal_axes = false;       ///< A unit is as long in both directions.
  std::vector<PlotCurve> curves;
  std::vector<PlotDots> dots = {};  ///< Over the curves, in this order.
  /// Lower left and upper right end of the axes; nullopt: what the curves need.
  std::optional<std::array<Eigen::Vector2d, 2>> range = std::nullopt;
};

void draw_panel(const PlotPanel& panel, PlotPen& pen);

/// Where the marks of an axis from `low` to `high` stand: about `count` round numbers.
std::vector<double> round_marks(double low, double high, int count);

}  // namespace rastro
