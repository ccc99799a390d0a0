// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/trajectory_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rastro/base/text.h"

namespace rastro {
namespace {

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

TrajectoryRow row_of(const SE3& pose, const SO3& first_rotation, bool camera_axes) {
  const Eigen::Vector3d angles = angles_of(first_rotation.inverse() * pose.rotation(), camera_axes);
  const Eigen::Vector3d& position = pose.translation();
  return {position.x(), position.y(), position.z(), angles.x(), angles.y(), angles.z()};
}

/// Of each pose of the reference; angles run on beyond 180 degrees.
std::vector<TrajectoryRow> reference_rows(const TrajectoryPlot& plot) {
  std::vector<TrajectoryRow> all;
  for (const SE3& pose : plot.reference) {
    TrajectoryRow row = row_of(pose, plot.reference.front().rotation(), plot.camera_axes);
    for (std::size_t k = 3; k < row.size() && !all.empty(); ++k)
      row[k] = all.back()[k] + within_180_deg(row[k] - all.back()[k]);
    all.push_back(row);
  }
  return all;
}

EstimateCurves curves_of(const PlottedEstimate& estimate, const TrajectoryPlot& plot,
                         const std::vector<TrajectoryRow>& reference) {
  EstimateCurves curves;
  for (std::size_t k = 0; k < estimate.poses.size(); ++k) {
    TrajectoryRow values = row_of(estimate.poses[k], plot.reference.front().rotation(), plot.camera_axes);
    const TrajectoryRow& ground_truth = reference[estimate.reference_index[k]];
    TrajectoryRow errors{};
    for (std::size_t row = 0; row < values.size(); ++row) {
      errors[row] = values[row] - ground_truth[row];
      if (row >= 3) errors[row] = within_180_deg(errors[row]);
      values[row] = ground_truth[row] + errors[row];
    }
    curves.values.push_back(values);
    curves.errors.push_back(errors);
  }
  return curves;
}

std::string csv_cells(const TrajectoryRow& row) {
  std::string text;
  // Rounded first, so that there is no "-0.000000".
  for (const double value : row) text += fmt::format(",{:.6f}", std::round(value * 1e6) / 1e6 + 0.0);
  return text;
}

/// A name in a cell of its own.
std::string csv_name(const std::string& name) {
  std::string quoted = "\"";
  for (const char letter : one_line(name)) quoted += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return quoted + "\"";
}

}  // namespace

TrajectoryCurves curves_of(const TrajectoryPlot& plot) {
  TrajectoryCurves curves;
  curves.reference = reference_rows(plot);
  for (const PlottedEstimate& estimate : plot.estimates)
    curves.estimates.push_back(curves_of(estimate, plot, curves.reference));
  return curves;
}

std::string trajectory_curves_as_csv(const TrajectoryPlot& plot) {
  const TrajectoryCurves curves = curves_of(plot);
  std::string text = fmt::format("estimate,{}", plot.along_label == "frame" ? "frame" : "time_s");
  for (const char* kind : {"", "error_"})
    for (const char* name : {"x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg"})
      text += fmt::format(",{}{}", kind, name);
  text += "\n";
  for (std::size_t k = 0; k < plot.estimates.size(); ++k) {
    const PlottedEstimate& estimate = plot.estimates[k];
    for (std::size_t i = 0; i < estimate.reference_index.size(); ++i)
      text += fmt::format("{},{}{}{}\n", csv_name(estimate.name), plot.along[estimate.reference_index[i]],
                          csv_cells(curves.estimates[k].values[i]), csv_cells(curves.estimates[k].errors[i]));
  }
  return text;
}

}  // namespace rastro
