// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"

namespace rastro::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double found_percent = 95.0;  ///< Of the frames: the place is recognized.

/// Of an even number the mean of the middle two; 0 without values.
double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::optional<double> mean_of(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double percent_of(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

int planned_runs(const BenchmarkEntry& entry) { return std::max<int>(1, static_cast<int>(entry.seeds.size())); }

const char* name_of(WarningDue due) { return due == WarningDue::yes ? "yes" : due == WarningDue::no ? "no" : "either"; }

/// The most of its disturbances; a map of another place may be refused.
WarningDue warning_due_of(const BenchmarkEntry& entry) {
  WarningDue most = entry.expect == Expectation::lost ? WarningDue::either : WarningDue::no;
  for (const std::string& disturbance : entry.disturbances) most = std::max(most, warning_due(disturbance));
  return most;
}

BenchmarkRow row_of(const BenchmarkEntry& entry, const std::vector<BenchmarkResult>& results) {
  BenchmarkRow row;
  row.name = entry.name;
  row.planned = planned_runs(entry);
  row.warning_due = warning_due_of(entry);
  std::vector<double> ates, times, cpu_times, inside_position, inside_rotation;
  std::int64_t frames = 0, tracked = 0;
  for (const BenchmarkResult& result : results) {
    if (result.entry != entry.name) continue;
    ++row.runs;
    const RunScores& scores = result.scores;
    row.warned += scores.warned ? 1 : 0;
    if (!result.failure.empty() && row.failed++ == 0) row.failure = result.failure;
    if (scores.ate_m) ates.push_back(*scores.ate_m);
    if (scores.inside_position_percent) inside_position.push_back(*scores.inside_position_percent);
    if (scores.inside_rotation_percent) inside_rotation.push_back(*scores.inside_rotation_percent);
    frames += scores.frames, tracked += scores.tracked;
    row.false_poses += scores.false_poses, row.false_poses_lost += scores.false_poses_lost;
    row.peak_memory_mb = std::max(row.peak_memory_mb, result.peak_memory_mb);
    if (scores.frames == 0) continue;
    times.push_back(1e3 * result.wall_s / static_cast<double>(scores.frames));
    cpu_times.push_back(1e3 * result.cpu_s / static_cast<double>(scores.frames));
  }
  row.inside_position_percent = mean_of(inside_position), row.inside_rotation_percent = mean_of(inside_rotation);
  row.tracked_percent = percent_of(tracked, frames);
  row.ms_per_frame = median_of(times), row.cpu_ms_per_frame = median_of(cpu_times);
  if (!ates.empty()) row.worst_ate_m = *std::max_element(ates.begin(), ates.end()), row.median_ate_m = median_of(ates);
  return row;
}

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

std::optional<double> optional_in(const Json& json, const char* key) {
  // Baselines saved before a value existed have none.
  return !json.contains(key) || json.at(key).is_null() ? std::nullopt : std::optional(json.at(key).get<double>());
}

Json json_of(const BenchmarkRow& row) {
  return {{"name", row.name},
          {"runs", row.runs},
          {"planned", row.planned},
          {"failed", row.failed},
          {"warned", row.warned},
          {"warning_due", name_of(row.warning_due)},
          {"median_ate_m", json_of(row.median_ate_m)},
          {"worst_ate_m", json_of(row.worst_ate_m)},
          {"inside_position_percent", json_of(row.inside_position_percent)},
          {"inside_rotation_percent", json_of(row.inside_rotation_percent)},
          {"tracked_percent", row.tracked_percent},
          {"false_poses", row.false_poses},
          {"false_poses_lost", row.false_poses_lost},
          {"ms_per_frame", row.ms_per_frame},
          {"cpu_ms_per_frame", row.cpu_ms_per_frame},
          {"peak_memory_mb", row.peak_memory_mb},
          {"failure", row.failure}};
}

BenchmarkRow row_in(const Json& json) {
  BenchmarkRow row;
  row.name = json.at("name").get<std::string>();
  row.runs = json.at("runs").get<int>(), row.planned = json.at("planned").get<int>();
  row.failed = json.at("failed").get<int>(), row.warned = json.at("warned").get<int>();
  const auto due = json.at("warning_due").get<std::string>();
  row.warning_due = due == "yes" ? WarningDue::yes : due == "no" ? WarningDue::no : WarningDue::either;
  row.median_ate_m = optional_in(json, "median_ate_m"), row.worst_ate_m = optional_in(json, "worst_ate_m");
  row.inside_position_percent = optional_in(json, "inside_position_percent");
  row.inside_rotation_percent = optional_in(json, "inside_rotation_percent");
  row.tracked_percent = json.at("tracked_percent").get<double>();
  row.false_poses = json.at("false_poses").get<std::int64_t>();
  row.false_poses_lost = json.at("false_poses_lost").get<std::int64_t>();
  row.ms_per_frame = json.at("ms_per_frame").get<double>();
  row.cpu_ms_per_frame = json.at("cpu_ms_per_frame").get<double>();
  row.peak_memory_mb = json.at("peak_memory_mb").get<double>();
  row.failure = json.at("failure").get<std::string>();
  return row;
}

const BenchmarkRow* find_row(const BenchmarkRows& rows, const std::string& name) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const BenchmarkRow& row) { return row.name == name; });
  return found == rows.end() ? nullptr : &*found;
}

/// What the row is compared with; null: nothing, as of a row that is not complete.
const BenchmarkRow* former_of(const BenchmarkRow& row, const BenchmarkRows& baseline) {
  return row.runs < row.planned ? nullptr : find_row(baseline, row.name);
}

std::string meters(const std::optional<double>& value) { return value ? fmt::format("{:.4f}", *value) : "-"; }
std::string milliseconds(double value) { return fmt::format("{:.1f}", value); }

std::string false_text(const BenchmarkRow& row) {
  return row.false_poses_lost > 0 ? fmt::format("{}+{}", row.false_poses, row.false_poses_lost)
                                  : fmt::format("{}", row.false_poses);
}

std::string inside_text(const BenchmarkRow& row) {
  if (!row.inside_position_percent || !row.inside_rotation_percent) return "-";
  return fmt::format("{:.0f}/{:.0f}", *row.inside_position_percent, *row.inside_rotation_percent);
}

constexpr std::size_t column_count = 11;
const std::vector<std::string> column_titles = {"entry",       "runs",   "median m", "worst m", "tracked %", "false",
                                                "inside 95 %", "warned", "ms/frame", "CPU ms",  "MB"};

std::vector<std::string> cells_of(const BenchmarkRow& row) {
  if (row.runs == 0) {
    std::vector<std::string> nothing(column_count, "-");
    nothing[0] = row.name, nothing[1] = fmt::format("0/{}", row.planned);
    return nothing;
  }
  return {row.name,
          row.runs == row.planned ? fmt::format("{}", row.runs) : fmt::format("{}/{}", row.runs, row.planned),
          meters(row.median_ate_m),
          meters(row.worst_ate_m),
          fmt::format("{:.1f}", row.tracked_percent),
          false_text(row),
          inside_text(row),
          fmt::format("{}", row.warned),
          milliseconds(row.ms_per_frame),
          milliseconds(row.cpu_ms_per_frame),
          fmt::format("{:.0f}", row.peak_memory_mb)};
}

/// The row's cells, each with that of the baseline where it differs.
std::vector<std::string> cells_beside(const BenchmarkRow& row, const BenchmarkRow* former) {
  std::vector<std::string> cells = cells_of(row);
  if (former == nullptr) return cells;
  const std::vector<std::string> before = cells_of(*former);
  for (std::size_t k = 1; k < column_count; ++k)
    if (cells[k] != before[k]) cells[k] += " (" + before[k] + ")";
  return cells;
}

/// Gathers the lines of what is worse.
class Comparison {
 public:
  Comparison(const BenchmarkRow& row, const BenchmarkRow& former) : row_(row), former_(former) {}

  void not_above(const char* what, double is, double was, double allowed, const char* unit, int digits) {
    if (is > was + allowed) add(what, fmt::format("{:.{}f}", is, digits), fmt::format("{:.{}f}", was, digits), unit);
  }

  void compare(const BenchmarkTolerance& tolerance) {
    compare_ate("median ATE", row_.median_ate_m, former_.median_ate_m, tolerance);
    compare_ate("worst ATE", row_.worst_ate_m, former_.worst_ate_m, tolerance);
    not_above("failed runs", row_.failed, former_.failed, 0.0, "", 0);
    not_above("false poses", total_false(row_), total_false(former_), 0.0, "", 0);
    not_above("untracked", 100.0 - row_.tracked_percent, 100.0 - former_.tracked_percent, tolerance.tracked_points,
              " %", 1);
    if (row_.warning_due == WarningDue::yes)
      not_above("runs without a warning", row_.runs - row_.warned, former_.runs - former_.warned, 0.0, "", 0);
    else if (row_.warning_due == WarningDue::no)
      not_above("false alarms", row_.warned, former_.warned, 0.0, "", 0);
    const auto share = [](double percent, double of) { return 0.01 * percent * of; };
    not_above("CPU time per frame", row_.cpu_ms_per_frame, former_.cpu_ms_per_frame,
              share(tolerance.time_percent, former_.cpu_ms_per_frame) + tolerance.time_ms, " ms", 1);
    not_above("memory", row_.peak_memory_mb, former_.peak_memory_mb,
              share(tolerance.memory_percent, former_.peak_memory_mb) + tolerance.memory_mb, " MB", 0);
  }

  std::vector<std::string> lines;

 private:
  static double total_false(const BenchmarkRow& row) {
    return static_cast<double>(row.false_poses + row.false_poses_lost);
  }

  void compare_ate(const char* what, const std::optional<double>& is, const std::optional<double>& was,
                   const BenchmarkTolerance& tolerance) {
    if (was && is) not_above(what, *is, *was, 0.01 * tolerance.ate_percent * *was + tolerance.ate_m, " m", 4);
    // A frame that is lost and said so is no error: without poses in both there is nothing to compare.
  }

  void add(const char* what, const std::string& is, const std::string& was, const char* unit) {
    lines.push_back(fmt::format("{}: {} {}{}, was {}{}", row_.name, what, is, unit, was, unit));
  }

  const BenchmarkRow& row_;
  const BenchmarkRow& former_;
};

}  // namespace

BenchmarkRows rows_of(const BenchmarkList& list, const std::vector<BenchmarkResult>& results) {
  BenchmarkRows rows;
  for (const BenchmarkEntry& entry : list.entries) rows.push_back(row_of(entry, results));
  return rows;
}

std::string to_json(const BenchmarkRows& rows) {
  Json json{{"benchmark", 1}, {"entries", Json::array()}};
  for (const BenchmarkRow& row : rows) json["entries"].push_back(json_of(row));
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

BenchmarkRows read_benchmark_rows(const std::filesystem::path& file) {
  try {
    const Json json = Json::parse(read_whole_file(file));
    BenchmarkRows rows;
    for (const Json& row : json.at("entries")) rows.push_back(row_in(row));
    return rows;
  } catch (const Json::exception&) {
    throw Error("is not a baseline", file.string(), "give a file written by 'rastro benchmark --save'");
  }
}

std::string table_text(const BenchmarkRows& rows, const BenchmarkRows& baseline) {
  std::vector<std::vector<std::string>> lines = {column_titles};
  for (const BenchmarkRow& row : rows) lines.push_back(cells_beside(row, find_row(baseline, row.name)));
  std::vector<std::size_t> widths(column_count, 0);
  for (const auto& line : lines)
    for (std::size_t k = 0; k < column_count; ++k) widths[k] = std::max(widths[k], line[k].size());
  std::string text;
  for (const auto& line : lines) {
    text += fmt::format("{:<{}}", line[0], widths[0]);
    for (std::size_t k = 1; k < column_count; ++k) text += fmt::format("  {:>{}}", line[k], widths[k]);
    text += "\n";
  }
  for (const BenchmarkRow& row : rows)
    if (row.failed > 0)
      text += fmt::format("{}: {} of {} runs failed; the first: {}\n", row.name, row.failed, row.runs, row.failure);
  return text;
}

std::vector<std::string> worse_than(const BenchmarkRows& rows, const BenchmarkRows& baseline,
                                    const BenchmarkTolerance& tolerance) {
  std::vector<std::string> lines;
  for (const BenchmarkRow& row : rows) {
    const BenchmarkRow* former = former_of(row, baseline);
    if (former == nullptr) continue;
    Comparison comparison(row, *former);
    comparison.compare(tolerance);
    lines.insert(lines.end(), comparison.lines.begin(), comparison.lines.end());
  }
  return lines;
}

int compared_with(const BenchmarkRows& rows, const BenchmarkRows& baseline) {
  const auto is_compared = [&](const BenchmarkRow& row) { return former_of(row, baseline) != nullptr; };
  return static_cast<int>(std::count_if(rows.begin(), rows.end(), is_compared));
}

std::string warnings_text(const BenchmarkRows& rows) {
  int wrong = 0, told = 0, right = 0, alarms = 0;
  for (const BenchmarkRow& row : rows) {
    if (row.warning_due == WarningDue::yes) wrong += row.runs, told += row.warned;
    if (row.warning_due == WarningDue::no) right += row.runs, alarms += row.warned;
  }
  return fmt::format("warnings: {} of {} runs with wrong input; {} of {} with right input (false alarms)\n", told,
                     wrong, alarms, right);
}

std::string expectations_text(const BenchmarkList& list, const std::vector<BenchmarkResult>& results) {
  int lost = 0, stayed_lost = 0, places = 0, found = 0;
  std::int64_t false_poses = 0;
  for (const BenchmarkEntry& entry : list.entries) {
    for (const BenchmarkResult& result : results) {
      if (entry.expect == Expectation::none || result.entry != entry.name) continue;
      const RunScores& scores = result.scores;
      false_poses += scores.false_poses + scores.false_poses_lost;
      const bool in_map = percent_of(scores.posed, scores.frames) >= found_percent && scores.false_poses == 0;
      (entry.expect == Expectation::found ? places : lost) += 1;
      if (entry.expect == Expectation::found && in_map) ++found;
      if (entry.expect == Expectation::lost && result.failure.empty() &&
          scores.false_poses + scores.false_poses_lost == 0)
        ++stayed_lost;
    }
  }
  if (lost + places == 0) return "";
  return fmt::format(
      "localization: {} of {} runs found the place (a pose for {:.0f} % of the frames, none false); {} of {} without "
      "the place gave no false pose; {} false poses\n",
      found, places, found_percent, stayed_lost, lost, false_poses);
}

}  // namespace rastro::cli
