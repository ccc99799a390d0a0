// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/trajectory_plot.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/export/trajectory_curves.h"
#include "rastro/export/trajectory_plot_panel.h"
#include "rastro/export/trajectory_plot_pen.h"

namespace rastro {
namespace {

constexpr int sheet_width = 1860, sheet_height = 1180;
constexpr double row_px = 178.0, row_frame_px = 138.0, top_px = 96.0;
constexpr double column_px = 580.0, column_frame_px = 490.0, left_px = 75.0;
constexpr PlotColor reference_color{20, 20, 20};
constexpr std::array<PlotColor, 6> estimate_colors = {
    {{214, 39, 40}, {31, 119, 180}, {44, 160, 44}, {255, 127, 14}, {148, 103, 189}, {23, 190, 207}}};
constexpr std::array<const char*, 6> row_names = {"x [m]", "y [m]", "z [m]", "roll [deg]", "pitch [deg]", "yaw [deg]"};

PlotColor color_of(std::size_t estimate) { return estimate_colors[estimate % estimate_colors.size()]; }

class Sheet {
 public:
  explicit Sheet(const TrajectoryPlot& plot) : plot_(plot), curves_(curves_of(plot)) {}

  void draw(PlotPen& pen) const {
    pen.text(plot_.title, {left_px, 30.0}, TextAnchor::left, 18.0, reference_color);
    draw_legend(pen);
    for (std::size_t row = 0; row < row_names.size(); ++row) {
      draw_panel(values_panel(row), pen);
      draw_panel(errors_panel(row), pen);
    }
    draw_panel(path_panel(), pen);
  }

 private:
  PlotPanel panel_at(std::size_t row, std::size_t column, const std::string& title) const {
    PlotPanel panel;
    panel.corner = {left_px + column_px * static_cast<double>(column), top_px + row_px * static_cast<double>(row)};
    panel.size = {column_frame_px, row_frame_px};
    panel.title = title;
    if (row + 1 == row_names.size()) panel.x_label = plot_.along_label;
    return panel;
  }

  PlotCurve curve(const std::vector<TrajectoryRow>& rows, std::size_t row, const PlottedEstimate& estimate,
                  PlotColor color) const {
    PlotCurve curve{{}, color};
    for (std::size_t k = 0; k < rows.size(); ++k)
      curve.points.emplace_back(plot_.along[estimate.reference_index[k]], rows[k][row]);
    return curve;
  }

  PlotPanel values_panel(std::size_t row) const {
    PlotPanel panel = panel_at(row, 0, row_names[row]);
    PlotCurve ground_truth{{}, reference_color};
    for (std::size_t k = 0; k < curves_.reference.size(); ++k)
      ground_truth.points.emplace_back(plot_.along[k], curves_.reference[k][row]);
    panel.curves.push_back(ground_truth);
    for (std::size_t k = 0; k < curves_.estimates.size(); ++k)
      panel.curves.push_back(curve(curves_.estimates[k].values, row, plot_.estimates[k], color_of(k)));
    return panel;
  }

  PlotPanel errors_panel(std::size_t row) const {
    PlotPanel panel = panel_at(row, 1, std::string("error of ") + row_names[row]);
    if (!plot_.along.empty())
      panel.curves.push_back({{{plot_.along.front(), 0.0}, {plot_.along.back(), 0.0}}, reference_color});
    for (std::size_t k = 0; k < curves_.estimates.size(); ++k)
      panel.curves.push_back(curve(curves_.estimates[k].errors, row, plot_.estimates[k], color_of(k)));
    return panel;
  }

  PlotPanel path_panel() const {
    const std::size_t up = plot_.y_is_down ? 2 : 1;
    PlotPanel panel;
    panel.corner = {left_px + 2.0 * column_px, top_px};
    panel.size = {sheet_width - panel.corner.x() - 30.0, sheet_width - panel.corner.x() - 30.0};
    panel.title = std::string("the path from above: ") + row_names[up] + " over " + row_names[0];
    panel.x_label = row_names[0];
    panel.equal_axes = true;
    panel.curves.push_back({path(curves_.reference, up), reference_color});
    for (std::size_t k = 0; k < curves_.estimates.size(); ++k)
      panel.curves.push_back({path(curves_.estimates[k].values, up), color_of(k)});
    return panel;
  }

  static std::vector<Eigen::Vector2d> path(const std::vector<TrajectoryRow>& rows, std::size_t up) {
    std::vector<Eigen::Vector2d> points;
    for (const TrajectoryRow& row : rows) points.emplace_back(row[0], row[up]);
    return points;
  }

  void draw_legend(PlotPen& pen) const {
    const auto entry = [&](std::size_t row, const std::string& name, PlotColor color) {
      const Eigen::Vector2d at(left_px + 2.0 * column_px, 860.0 + 24.0 * static_cast<double>(row));
      pen.line({at, at + Eigen::Vector2d(40.0, 0.0)}, color, 3.0);
      pen.text(name, at + Eigen::Vector2d(50.0, 5.0), TextAnchor::left, 14.0, reference_color);
    };
    entry(0, "reference", reference_color);
    for (std::size_t k = 0; k < plot_.estimates.size(); ++k)
      entry(k + 1, one_line(plot_.estimates[k].name), color_of(k));
  }

  const TrajectoryPlot& plot_;
  TrajectoryCurves curves_;
};

bool is_svg(const std::string& file) { return std::filesystem::path(file).extension() == ".svg"; }

}  // namespace

void require_plot_name(const std::string& file) {
  if (is_svg(file) || std::filesystem::path(file).extension() == ".png") return;
  throw Error("the plot's name must end in .svg or .png", file, "");
}

void write_trajectory_plot(const TrajectoryPlot& plot, const std::string& file) {
  require_plot_name(file);
  if (plot.reference.empty()) throw Error("there is nothing to plot", file, "");
  RASTRO_CHECK(plot.along.size() == plot.reference.size(), "every pose of the reference has its frame or time");
  const auto pen = pen_for(file, sheet_width, sheet_height);
  Sheet(plot).draw(*pen);
  pen->save(file);
}

}  // namespace rastro
