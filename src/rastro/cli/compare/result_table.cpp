// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/result_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/math/median.h"

namespace rastro::cli {
namespace {

constexpr const char* error_figure = "ate_m";
constexpr const char* completion_figure = "completion_percent";

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

void ResultTable::add_input(const std::string& input) { add_once(inputs_, input); }
void ResultTable::add_column(const std::string& column) { add_once(columns_, column); }

void ResultTable::add(const std::string& input, const std::string& column, const std::string& figure, Sample sample) {
  add_input(input);
  add_column(column);
  cells_[{input, column, figure}].push_back(std::move(sample));
}

const std::vector<Sample>& ResultTable::samples(const std::string& input, const std::string& column,
                                                const std::string& figure) const {
  static const std::vector<Sample> none;
  const auto found = cells_.find({input, column, figure});
  return found == cells_.end() ? none : found->second;
}

std::vector<double> ResultTable::values(const std::string& input, const std::string& column,
                                        const std::string& figure) const {
  std::vector<double> all;
  for (const Sample& sample : samples(input, column, figure)) all.push_back(sample.value);
  return all;
}

std::optional<double> ResultTable::median(const std::string& input, const std::string& column,
                                          const std::string& figure) const {
  std::vector<double> all = values(input, column, figure);
  if (all.empty()) return std::nullopt;
  return rastro::median(std::move(all));
}

int ResultTable::runs(const std::string& input, const std::string& column) const {
  return static_cast<int>(
      std::max(samples(input, column, completion_figure).size(), samples(input, column, error_figure).size()));
}

int ResultTable::runs_without_error(const std::string& input, const std::string& column) const {
  const auto has_error = [&](const std::string& each) { return !samples(input, each, error_figure).empty(); };
  if (std::none_of(columns_.begin(), columns_.end(), has_error)) return 0;
  return runs(input, column) - static_cast<int>(samples(input, column, error_figure).size());
}

std::optional<double> ResultTable::median_error(const std::string& input, const std::string& column) const {
  std::vector<double> all = values(input, column, error_figure);
  if (all.empty()) return std::nullopt;
  all.resize(static_cast<std::size_t>(runs(input, column)), std::numeric_limits<double>::infinity());
  const double middle = rastro::median(std::move(all));
  return std::isfinite(middle) ? std::optional(middle) : std::nullopt;
}

std::optional<double> ResultTable::worst(const std::string& input, const std::string& column,
                                         const FigureKind& figure) const {
  const std::vector<double> all = values(input, column, figure.name);
  if (all.empty()) return std::nullopt;
  if (figure.more_is_better) return *std::min_element(all.begin(), all.end());
  return *std::max_element(all.begin(), all.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
}

std::vector<std::string> ResultTable::columns_on(const std::string& input) const {
  std::vector<std::string> all;
  for (const std::string& column : columns_) {
    const auto has = [&](const auto& cell) {
      return std::get<0>(cell.first) == input && std::get<1>(cell.first) == column;
    };
    if (std::any_of(cells_.begin(), cells_.end(), has)) all.push_back(column);
  }
  return all;
}

MarkOnInput mark_on(const ResultTable& table, const std::string& input, const std::vector<std::string>& columns) {
  constexpr double half_percent = 50.0;
  MarkOnInput mark;
  for (const double least : {half_percent, 0.0}) {
    for (const std::string& column : columns) {
      const auto error_m = table.median_error(input, column);
      if (error_m && table.median(input, column, "completion_percent").value_or(0.0) >= least)
        mark.error_m = std::min(mark.error_m.value_or(*error_m), *error_m);
    }
    if (mark.error_m) break;
  }
  for (const std::string& column : columns) {
    const auto error_m = table.median_error(input, column);
    if (error_m && *error_m <= most_error_factor * *mark.error_m)
      mark.completion_percent =
          std::max(mark.completion_percent, table.median(input, column, "completion_percent").value_or(0.0));
  }
  return mark;
}

std::string best_on(const ResultTable& table, const std::string& input, std::vector<std::string> columns) {
  const MarkOnInput mark = mark_on(table, input, columns);
  std::erase_if(columns, [&](const std::string& column) {
    return !table.median_error(input, column) || table.median(input, column, "completion_percent").value_or(0.0) <
                                                     mark.completion_percent - completion_points;
  });
  const auto best = std::min_element(columns.begin(), columns.end(), [&](const auto& a, const auto& b) {
    return table.median_error(input, a) < table.median_error(input, b);
  });
  return best == columns.end() ? "" : *best;
}

const std::vector<FigureKind>& compare_figures() {
  static const std::vector<FigureKind> figures = {
      {"completion_percent", "complete [%]", 1, true, "Frames in state tracking, weak or relocalized, of all frames."},
      {"ate_m", "ATE [m]", 4, false, "Absolute trajectory error, rmse over the frames with a pose, after alignment."},
      {"rpe_frame_m", "RPE frame [m]", 4, false, "Relative pose error from frame to frame, translation, rmse.", false},
      {"rpe_second_m", "RPE 1 s [m]", 4, false, "Relative pose error over one second, translation, rmse."},
      {"rpe_second_deg", "RPE 1 s [deg]", 3, false, "The same, rotation.", false},
      {"drift_percent", "drift [%]", 2, false, "Error of the motion from the first pose to the last, per path."},
      {"scale_error_percent", "scale [%]", 2, false,
       "Lengths of the estimate over true ones, minus 1, of a run that claims meters."},
      {"scale_drift_percent", "scale drift [%]", 2, false,
       "Scale of the second half of the poses over that of the first, minus 1.", false},
      {"inside_position_percent", "inside 95 % [%]", 0, true,
       "Positions inside the ellipse that should hold 95 % of them."},
      {"false_percent", "false [%]", 1, false,
       "Frames whose pose is farther off than the limit (0.1 m), of all frames."},
      {"frame_ms", "ms/frame", 1, false, "Time of the method per frame, mean."},
      {"frame_p95_ms", "95 % [ms]", 1, false, "The time that 95 % of the frames keep.", false},
      {"frames_per_second", "frames/s", 1, true, "1000 / (ms/frame)."},
      {"cpu_ms", "CPU ms/frame", 1, false, "Of the whole process, over all threads, reading and saving included.",
       false},
      {"memory_mb", "MB", 0, false, "Largest resident memory of the process."},
      {"start_s", "start [s]", 2, false, "From the first frame to the first one that is tracked."},
      {"longest_loss_s", "longest loss [s]", 2, false, "Longest time without tracking after the first pose.", false},
      {"surface_median_m", "surface [m]", 4, false, "Median distance of the points of the map from the true surfaces."},
      {"surface_complete_percent", "surface complete [%]", 1, true,
       "True surfaces with a point of the map within 2 cm, seen or not.", false},
      {"lengths_measured_percent", "lengths [%]", 0, true, "Named lengths that could be measured in the map."},
      {"length_mean_m", "length mean [m]", 4, false, "Mean error of the named lengths."},
      {"length_max_m", "length max [m]", 4, false, "Largest error of the named lengths."},
      {"length_sigmas", "error/sigma", 2, false,
       "Root mean square of error by claimed sigma of the lengths: 1 is honest, above it is overconfident."},
      {"same_bytes_percent", "same bytes [%]", 0, true, "Runs repeated with the same seed that gave the same bytes."}};
  return figures;
}

const FigureKind& compare_figure(const std::string& name) {
  const auto& all = compare_figures();
  const auto found = std::find_if(all.begin(), all.end(), [&](const FigureKind& each) { return each.name == name; });
  RASTRO_CHECK(found != all.end(), "not a figure of compare");
  return *found;
}

std::string figure_text(const FigureKind& figure, const std::optional<double>& value) {
  return value ? fmt::format("{:.{}f}", *value, figure.digits) : "-";
}

}  // namespace rastro::cli
