// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "rastro/export/trajectory_plot_pen.h"

namespace rastro {

/// One curve in the units of the axes.
struct PlotCurve {
  std::vector<Eigen::Vector2d> points;
  PlotColor color;
};

/// A frame with axes and curves in it.
struct PlotPanel {
  Eigen::Vector2d corner, size;  ///< Of the frame, pixels; the numbers of the axes stand left of it and below.
  std::string title;             ///< Above the frame.
  std::string x_label;           ///< Below it; empty: no numbers there either.
  bool equal_axes = false;       ///< A unit is as long in both directions.
  std::vector<PlotCurve> curves;
};

void draw_panel(const PlotPanel& panel, PlotPen& pen);

/// Where the marks of an axis from `low` to `high` stand: about `count` round numbers.
std::vector<double> round_marks(double low, double high, int count);

}  // namespace rastro
