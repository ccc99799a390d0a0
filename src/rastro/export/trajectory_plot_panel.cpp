// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/trajectory_plot_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

constexpr PlotColor black{30, 30, 30};
constexpr PlotColor faint{222, 222, 222};
constexpr double letter_px = 12.0;
constexpr double rim = 0.05;            ///< Part of the range left free at either end of an axis.
constexpr double nearest_points = 0.4;  ///< Pixels; a point nearer to the last one drawn adds nothing to see.

struct Range {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(0.0), high = Eigen::Vector2d::Constant(1.0);
};

Range range_of(const PlotPanel& panel) {
  if (panel.range) return {panel.range->front(), panel.range->back()};
  Range range;
  bool any = false;
  for (const PlotCurve& curve : panel.curves)
    for (const Eigen::Vector2d& point : curve.points) {
      range.low = any ? range.low.cwiseMin(point).eval() : point;
      range.high = any ? range.high.cwiseMax(point).eval() : point;
      any = true;
    }
  for (int axis = 0; axis < 2; ++axis) {
    const double extent = range.high[axis] - range.low[axis];
    // A flat curve still needs an axis to stand on.
    const double more = extent > 0.0 ? rim * extent : std::max(1e-3, 1e-3 * std::abs(range.low[axis]));
    if (axis == 0 && !panel.equal_axes && extent > 0.0) continue;
    range.low[axis] -= more;
    range.high[axis] += more;
  }
  return range;
}

/// Widens the shorter direction until a unit is as long in both.
void make_equal(Range& range, const Eigen::Vector2d& size) {
  const Eigen::Vector2d extent = range.high - range.low;
  const double unit = std::max(extent.x() / size.x(), extent.y() / size.y());
  const Eigen::Vector2d more = 0.5 * (unit * size - extent);
  range.low -= more;
  range.high += more;
}

class Axes {
 public:
  Axes(const PlotPanel& panel, const Range& range) : corner_(panel.corner), size_(panel.size), range_(range) {}
  Eigen::Vector2d operator()(double x, double y) const {
    return {corner_.x() + size_.x() * (x - range_.low.x()) / (range_.high.x() - range_.low.x()),
            corner_.y() + size_.y() * (range_.high.y() - y) / (range_.high.y() - range_.low.y())};
  }

 private:
  Eigen::Vector2d corner_, size_;
  Range range_;
};

void draw_marks(const PlotPanel& panel, const Range& range, const Axes& axes, PlotPen& pen) {
  const int most_rows = std::max(2, static_cast<int>(panel.size.y() / 25.0));
  for (const double y : round_marks(range.low.y(), range.high.y(), most_rows)) {
    pen.line({axes(range.low.x(), y), axes(range.high.x(), y)}, faint, 1.0);
    pen.text(fmt::format("{:.6g}", y), axes(range.low.x(), y) + Eigen::Vector2d(-5.0, 4.0), TextAnchor::right,
             letter_px, black);
  }
  const int most_columns = std::max(2, static_cast<int>(panel.size.x() / 80.0));
  for (const double x : round_marks(range.low.x(), range.high.x(), most_columns)) {
    pen.line({axes(x, range.low.y()), axes(x, range.high.y())}, faint, 1.0);
    if (panel.x_label.empty()) continue;
    pen.text(fmt::format("{:.6g}", x), axes(x, range.low.y()) + Eigen::Vector2d(0.0, 16.0), TextAnchor::middle,
             letter_px, black);
  }
}

std::vector<Eigen::Vector2d> on_sheet(const PlotCurve& curve, const Axes& axes) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& point : curve.points) {
    const Eigen::Vector2d pixel = axes(point.x(), point.y());
    if (points.empty() || (pixel - points.back()).norm() >= nearest_points) points.push_back(pixel);
  }
  return points;
}

}  // namespace

std::vector<double> round_marks(double low, double high, int count) {
  const double wanted = (high - low) / std::max(1, count);
  if (!(wanted > 0.0) || !std::isfinite(wanted)) return {};
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  double step = 10.0 * decade;
  for (const double digit : {5.0, 2.0, 1.0})
    if (digit * decade >= wanted) step = digit * decade;
  std::vector<double> marks;
  const double first = std::ceil(low / step), last = std::floor(high / step);
  // Beyond 2^53 steps from zero, neighboring marks are one number.
  if (std::max(std::abs(first), std::abs(last)) > 9e15) return {};
  for (double k = first; k <= last; ++k) marks.push_back(k == 0.0 ? 0.0 : k * step);
  return marks;
}

void draw_panel(const PlotPanel& panel, PlotPen& pen) {
  Range range = range_of(panel);
  if (panel.equal_axes) make_equal(range, panel.size);
  const Axes axes(panel, range);
  draw_marks(panel, range, axes, pen);
  const Eigen::Vector2d &low = range.low, &high = range.high;
  pen.line({axes(low.x(), low.y()), axes(high.x(), low.y()), axes(high.x(), high.y()), axes(low.x(), high.y()),
            axes(low.x(), low.y())},
           black, 1.0);
  for (const PlotCurve& curve : panel.curves) pen.line(on_sheet(curve, axes), curve.color, 1.2);
  for (const PlotDots& dots : panel.dots)
    for (const Eigen::Vector2d& point : dots.points) pen.dot(axes(point.x(), point.y()), dots.color, dots.radius);
  pen.text(panel.title, panel.corner + Eigen::Vector2d(0.0, -6.0), TextAnchor::left, letter_px + 1.0, black);
  if (!panel.x_label.empty())
    pen.text(panel.x_label, panel.corner + Eigen::Vector2d(0.5 * panel.size.x(), panel.size.y() + 34.0),
             TextAnchor::middle, letter_px, black);
}

}  // namespace rastro
