// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/trajectory_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
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

/// x, y, z in meters, then roll, pitch, yaw in degrees: the six rows of the plot.
using Rows = std::array<double, 6>;

double within_180_deg(double degrees) { return std::remainder(degrees, 360.0); }

/// Roll, pitch, yaw in degrees.
Eigen::Vector3d angles_of(const SO3& rotation, bool camera_axes) {
  const Eigen::Matrix3d r = rotation.matrix();
  const auto asin_of = [](double sine) { return std::asin(std::clamp(sine, -1.0, 1.0)); };
  const Eigen::Vector3d radians =
      camera_axes ? Eigen::Vector3d(std::atan2(r(1, 0), r(1, 1)), asin_of(-r(1, 2)), std::atan2(r(0, 2), r(2, 2)))
                  : Eigen::Vector3d(std::atan2(r(2, 1), r(2, 2)), asin_of(-r(2, 0)), std::atan2(r(1, 0), r(0, 0)));
  return radians * 180.0 / std::numbers::pi;
}

Rows rows_of(const SE3& pose, const SO3& first_rotation, bool camera_axes) {
  const Eigen::Vector3d angles = angles_of(first_rotation.inverse() * pose.rotation(), camera_axes);
  const Eigen::Vector3d& position = pose.translation();
  return {position.x(), position.y(), position.z(), angles.x(), angles.y(), angles.z()};
}

/// Of each pose of the reference; angles run on beyond 180 degrees.
std::vector<Rows> reference_rows(const TrajectoryPlot& plot) {
  std::vector<Rows> all;
  for (const SE3& pose : plot.reference) {
    Rows rows = rows_of(pose, plot.reference.front().rotation(), plot.camera_axes);
    for (std::size_t k = 3; k < rows.size() && !all.empty(); ++k)
      rows[k] = all.back()[k] + within_180_deg(rows[k] - all.back()[k]);
    all.push_back(rows);
  }
  return all;
}

struct EstimateRows {
  std::vector<Rows> values, errors;
};

EstimateRows rows_of(const PlottedEstimate& estimate, const TrajectoryPlot& plot, const std::vector<Rows>& reference) {
  EstimateRows result;
  for (std::size_t k = 0; k < estimate.poses.size(); ++k) {
    Rows values = rows_of(estimate.poses[k], plot.reference.front().rotation(), plot.camera_axes);
    const Rows& ground_truth = reference[estimate.reference_index[k]];
    Rows errors{};
    for (std::size_t row = 0; row < values.size(); ++row) {
      errors[row] = values[row] - ground_truth[row];
      if (row >= 3) errors[row] = within_180_deg(errors[row]);
      values[row] = ground_truth[row] + errors[row];
    }
    result.values.push_back(values);
    result.errors.push_back(errors);
  }
  return result;
}

PlotColor color_of(std::size_t estimate) { return estimate_colors[estimate % estimate_colors.size()]; }

class Sheet {
 public:
  explicit Sheet(const TrajectoryPlot& plot) : plot_(plot), reference_(reference_rows(plot)) {
    for (const PlottedEstimate& estimate : plot.estimates) estimates_.push_back(rows_of(estimate, plot, reference_));
  }

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

  PlotCurve curve(const std::vector<Rows>& rows, std::size_t row, const PlottedEstimate& estimate,
                  PlotColor color) const {
    PlotCurve curve{{}, color};
    for (std::size_t k = 0; k < rows.size(); ++k)
      curve.points.emplace_back(plot_.along[estimate.reference_index[k]], rows[k][row]);
    return curve;
  }

  PlotPanel values_panel(std::size_t row) const {
    PlotPanel panel = panel_at(row, 0, row_names[row]);
    PlotCurve ground_truth{{}, reference_color};
    for (std::size_t k = 0; k < reference_.size(); ++k)
      ground_truth.points.emplace_back(plot_.along[k], reference_[k][row]);
    panel.curves.push_back(ground_truth);
    for (std::size_t k = 0; k < estimates_.size(); ++k)
      panel.curves.push_back(curve(estimates_[k].values, row, plot_.estimates[k], color_of(k)));
    return panel;
  }

  PlotPanel errors_panel(std::size_t row) const {
    PlotPanel panel = panel_at(row, 1, std::string("error of ") + row_names[row]);
    if (!plot_.along.empty())
      panel.curves.push_back({{{plot_.along.front(), 0.0}, {plot_.along.back(), 0.0}}, reference_color});
    for (std::size_t k = 0; k < estimates_.size(); ++k)
      panel.curves.push_back(curve(estimates_[k].errors, row, plot_.estimates[k], color_of(k)));
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
    panel.curves.push_back({path(reference_, up), reference_color});
    for (std::size_t k = 0; k < estimates_.size(); ++k)
      panel.curves.push_back({path(estimates_[k].values, up), color_of(k)});
    return panel;
  }

  static std::vector<Eigen::Vector2d> path(const std::vector<Rows>& rows, std::size_t up) {
    std::vector<Eigen::Vector2d> points;
    for (const Rows& row : rows) points.emplace_back(row[0], row[up]);
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
  std::vector<Rows> reference_;
  std::vector<EstimateRows> estimates_;
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
