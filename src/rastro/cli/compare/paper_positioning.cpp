// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/paper_positioning.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

namespace rastro::cli {
namespace {

constexpr double deg_per_rad = 180.0 / std::numbers::pi;
constexpr std::array<const char*, 3> axis_names = {"X, forward", "Y, left", "Z, up"};
constexpr std::array<const char*, 3> angle_names = {"roll", "pitch", "yaw"};

/// What the text of the paper reads off figures 12 and 10, on drive 0014 of KITTI raw: the largest error along each
/// axis, and the error of the yaw near frame 50.
struct Published {
  const char* method;
  std::array<const char*, 3> errors_m;
  const char* yaw_deg;
};
constexpr std::size_t frame_of_yaw = 50;
constexpr Published published[] = {
    {"classic", {"20", "80", "5"}, "-"},
    {"profiles", {"-", "-", "-"}, "7"},
    {"hybrid", {"20", "20", "10"}, "-"},
    {"features", {"-", "-", "-"}, "-"},
};

/// Rows: X, Y, Z of the vehicle in the axes of the camera.
Eigen::Matrix3d vehicle_from_camera_axes() {
  Eigen::Matrix3d axes;
  axes << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return axes;
}

Eigen::Vector3d angles_of(const Eigen::Matrix3d& first_from_now) {
  return deg_per_rad * Eigen::Vector3d(std::atan2(first_from_now(2, 1), first_from_now(2, 2)),
                                       -std::asin(std::clamp(first_from_now(2, 0), -1.0, 1.0)),
                                       std::atan2(first_from_now(1, 0), first_from_now(0, 0)));
}

/// The turn nearest to the one before.
double unwrapped(double angle_deg, double before_deg) {
  return angle_deg - 360.0 * std::round((angle_deg - before_deg) / 360.0);
}

/// One method and the ground truth over the same frames, both since the first pose of the ground truth.
struct Compared {
  std::string column;
  std::size_t color = 0;
  VehicleMotion is, truth;
  std::optional<std::size_t> at_yaw;  ///< Of these frames the one that the paper reads the yaw at.
};

/// Positions after the alignment; orientations without it, as if the estimate began in that of the ground truth.
Trajectory begun_as_truth(const RunTrace& trace) {
  const Trajectory &truth = trace.reference->input.poses, &aligned = trace.scores.aligned;
  const SO3 truth_from_estimate = truth[trace.scores.pairs.front().reference].world_from_body.rotation() *
                                  aligned.front().world_from_body.rotation().inverse();
  Trajectory begun;
  for (std::size_t k = 0; k < aligned.size(); ++k)
    begun.push_back(
        {truth[trace.scores.pairs[k].reference].stamp,
         SE3(truth_from_estimate * aligned[k].world_from_body.rotation(), aligned[k].world_from_body.translation())});
  return begun;
}

VehicleMotion matched_of(const VehicleMotion& whole, const std::vector<PosePair>& pairs) {
  VehicleMotion matched;
  for (const PosePair& pair : pairs) {
    matched.times_s.push_back(whole.times_s[pair.reference]);
    matched.positions_m.push_back(whole.positions_m[pair.reference]);
    matched.angles_deg.push_back(whole.angles_deg[pair.reference]);
  }
  return matched;
}

/// The pair of a frame of the recording; of a trajectory without frames that of the ground truth's pose of this number.
std::optional<std::size_t> pair_at(const RunTrace& trace, std::size_t number) {
  constexpr TimeNs same_stamp = 1'000'000;  // files give stamps with fewer digits than frames have
  const auto frame = std::find_if(trace.frames.begin(), trace.frames.end(), [&](const RunFrame& each) {
    return each.frame == static_cast<std::int64_t>(number);
  });
  if (!trace.frames.empty() && frame == trace.frames.end()) return std::nullopt;
  for (std::size_t k = 0; k < trace.scores.pairs.size(); ++k) {
    const PosePair& pair = trace.scores.pairs[k];
    if (trace.frames.empty() ? pair.reference == number
                             : std::abs(trace.estimate.poses[pair.estimate].stamp - frame->stamp) < same_stamp)
      return k;
  }
  return std::nullopt;
}

Compared compared_of(const ColumnTrace& each, std::size_t color) {
  const RunTrace& trace = each.trace;
  const Trajectory& reference = trace.reference->input.poses;
  const bool of_camera = !trace.reference->of_body;
  Compared compared{each.column, color, vehicle_motion(begun_as_truth(trace), of_camera, reference.front()),
                    matched_of(vehicle_motion(reference, of_camera, reference.front()), trace.scores.pairs),
                    pair_at(trace, frame_of_yaw)};
  // A method that begins after a whole turn begins with that, as the ground truth does.
  const double begin_deg = compared.is.angles_deg.front().z();
  const double turns_deg = unwrapped(begin_deg, compared.truth.angles_deg.front().z()) - begin_deg;
  for (Eigen::Vector3d& angles : compared.is.angles_deg) angles.z() += turns_deg;
  return compared;
}

std::vector<double> component(const std::vector<Eigen::Vector3d>& vectors, int axis) {
  std::vector<double> values;
  for (const Eigen::Vector3d& vector : vectors) values.push_back(vector[axis]);
  return values;
}

std::vector<double> minus(std::vector<double> values, const std::vector<double>& others) {
  for (std::size_t k = 0; k < values.size(); ++k) values[k] -= others[k];
  return values;
}

std::vector<double> steps_of(const std::vector<double>& values) {
  std::vector<double> steps(values.size(), 0.0);
  for (std::size_t k = 1; k < values.size(); ++k) steps[k] = values[k] - values[k - 1];
  return steps;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

std::vector<double> errors_along(const Compared& method, int axis) {
  return minus(component(method.is.positions_m, axis), component(method.truth.positions_m, axis));
}

std::vector<double> angle_errors(const Compared& method, int angle) {
  return minus(component(method.is.angles_deg, angle), component(method.truth.angles_deg, angle));
}

std::vector<std::string> row_of(const Compared& method, const Published& paper) {
  std::vector<std::string> row = {method.column};
  for (int axis = 0; axis < 3; ++axis) {
    row.push_back(fmt::format("{:.2f}", largest(errors_along(method, axis))));
    row.emplace_back(paper.errors_m[static_cast<std::size_t>(axis)]);
  }
  const std::vector<double> yaw = angle_errors(method, 2);
  row.push_back(method.at_yaw ? fmt::format("{:.2f}", std::abs(yaw[*method.at_yaw])) : "-");
  row.emplace_back(paper.yaw_deg);
  row.push_back(fmt::format("{:.2f}", largest(yaw)));
  return row;
}

/// `value` of every method over time; `with_truth` also for the ground truth over the frames of the longest of them.
template <typename Value>
Chart chart_of(const std::string& title, const std::string& unit, const std::vector<Compared>& methods, bool with_truth,
               const Value& value) {
  Chart chart{title, "seconds", unit, {}, false, false};
  if (with_truth) {
    const auto longest = std::max_element(methods.begin(), methods.end(), [](const Compared& a, const Compared& b) {
      return a.truth.times_s.size() < b.truth.times_s.size();
    });
    const VehicleMotion& truth = longest->truth;
    chart.lines.push_back({"ground truth", truth.times_s, value(truth), 0, true, false});
  }
  for (const Compared& method : methods) {
    const VehicleMotion& is = method.is;
    std::vector<double> values = value(is);
    if (!with_truth) values = minus(std::move(values), value(method.truth));
    chart.lines.push_back({method.column, is.times_s, std::move(values), method.color, false, false});
  }
  return chart;
}

std::vector<Chart> charts_of(const std::vector<Compared>& methods) {
  const auto yaw = [](const VehicleMotion& motion) { return component(motion.angles_deg, 2); };
  std::vector<Chart> charts = {chart_of("Figure 9: yaw from frame to frame", "degrees", methods, true,
                                        [&yaw](const VehicleMotion& motion) { return steps_of(yaw(motion)); }),
                               chart_of("Figure 10: accumulated yaw", "degrees", methods, true, yaw)};
  for (const bool of_error : {false, true})
    for (int axis = 0; axis < 3; ++axis)
      charts.push_back(chart_of(fmt::format("Figure {}: {}{}", of_error ? 12 : 11, of_error ? "error, " : "",
                                            axis_names[static_cast<std::size_t>(axis)]),
                                "meters", methods, !of_error,
                                [axis](const VehicleMotion& motion) { return component(motion.positions_m, axis); }));
  for (const bool of_error : {false, true})
    for (int angle = 0; angle < 3; ++angle)
      charts.push_back(chart_of(fmt::format("Figure {}: {}{}", of_error ? 14 : 13, of_error ? "error, " : "",
                                            angle_names[static_cast<std::size_t>(angle)]),
                                "degrees", methods, !of_error,
                                [angle](const VehicleMotion& motion) { return component(motion.angles_deg, angle); }));
  return charts;
}

PaperTable table_on(const Comparison& comparison, const std::vector<ColumnTrace>& traces, std::size_t input) {
  PaperTable table;
  table.title = fmt::format("The positioning paper's figures 9 to 14: {}", comparison.inputs[input].name);
  table.rows = {{"method", "X max [m]", "paper", "Y max [m]", "paper", "Z max [m]", "paper",
                 fmt::format("yaw at frame {} [deg]", frame_of_yaw), "paper", "yaw max [deg]"}};
  const std::vector<std::string>& columns = comparison.table.columns();
  std::vector<Compared> methods;
  for (const ColumnTrace* each : median_traces(traces, columns, input)) {
    const auto* paper = std::find_if(std::begin(published), std::end(published),
                                     [&](const Published& candidate) { return candidate.method == each->column; });
    if (paper == std::end(published)) continue;
    const auto color = std::find(columns.begin(), columns.end(), each->column) - columns.begin();
    methods.push_back(compared_of(*each, static_cast<std::size_t>(color)));
    table.rows.push_back(row_of(methods.back(), *paper));
  }
  if (!methods.empty()) table.charts = charts_of(methods);
  return table;
}

}  // namespace

VehicleMotion vehicle_motion(const Trajectory& poses, bool of_camera, const StampedPose& start) {
  VehicleMotion motion;
  const Eigen::Matrix3d axes = of_camera ? vehicle_from_camera_axes() : Eigen::Matrix3d::Identity();
  const SE3 first_from_world = start.world_from_body.inverse();
  for (const StampedPose& pose : poses) {
    const SE3 first_from_now = first_from_world * pose.world_from_body;
    motion.times_s.push_back(to_seconds(pose.stamp - start.stamp));
    motion.positions_m.emplace_back(axes * first_from_now.translation());
    Eigen::Vector3d angles = angles_of(axes * first_from_now.rotation().matrix() * axes.transpose());
    if (!motion.angles_deg.empty()) angles.z() = unwrapped(angles.z(), motion.angles_deg.back().z());
    motion.angles_deg.push_back(angles);
  }
  return motion;
}

std::vector<PaperTable> paper_positioning_tables(const Comparison& comparison, const std::vector<ColumnTrace>& traces) {
  std::vector<PaperTable> tables;
  for (std::size_t input = 0; input < comparison.inputs.size(); ++input) {
    if (comparison.inputs[input].facts.has_depth) continue;
    PaperTable table = table_on(comparison, traces, input);
    if (table.rows.size() > 1) tables.push_back(std::move(table));
  }
  if (!tables.empty())
    tables.back().note =
        "The paper's are read off its text, on 2011_09_26_drive_0014 of KITTI raw ('rastro compare --paper FOLDER' "
        "compares "
        "on it). Positions are aligned by a similarity, since the scale of one camera is not known; angles count from "
        "the first pose of the ground truth, without an alignment: a method that begins later begins in its "
        "orientation.";
  return tables;
}

}  // namespace rastro::cli
