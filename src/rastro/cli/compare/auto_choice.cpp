// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/auto_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace rastro::cli {
namespace {

bool is_slam(const Comparison& comparison, const std::string& column) {
  return std::any_of(comparison.runs.begin(), comparison.runs.end(), [&](const FinishedRun& run) {
    return run.what.column == column && run.run_command.starts_with("rastro slam ");
  });
}

/// Errors below that are rounding.
constexpr double smallest_error_m = 1e-6;

/// Where auto gave a path, those that are aligned as it is.
std::vector<std::string> rivals(const Comparison& comparison, std::size_t input, bool has_path) {
  const std::string& name = comparison.inputs[input].name;
  std::vector<std::string> columns;
  for (const std::string& column : comparison.table.columns_on(name))
    if (column != auto_column && is_slam(comparison, column) && comparison.table.median(name, column, "ate_m") &&
        (!has_path || alignment_text(comparison, input, column) == alignment_text(comparison, input, auto_column)))
      columns.push_back(column);
  return columns;
}

}  // namespace

std::optional<double> AutoOnInput::ratio() const {
  if (!error_m || completion_percent < best_completion_percent - completion_points) return std::nullopt;
  return std::max(*error_m, smallest_error_m) / std::max(best_error_m, smallest_error_m);
}

std::vector<AutoOnInput> auto_on_inputs(const Comparison& comparison) {
  std::vector<AutoOnInput> all;
  const ResultTable& table = comparison.table;
  for (std::size_t k = 0; k < comparison.inputs.size(); ++k) {
    const std::string& name = comparison.inputs[k].name;
    const bool was_run = std::any_of(comparison.runs.begin(), comparison.runs.end(), [&](const FinishedRun& run) {
      return run.is_plain() && run.what.input == k && run.what.column == auto_column;
    });
    const auto error = table.median_error(name, auto_column);
    const std::vector<std::string> columns = rivals(comparison, k, error.has_value());
    const std::string best = best_on(table, name, columns);
    if (!was_run || best.empty()) continue;
    all.push_back({name, best, error, *table.median_error(name, best),
                   table.median(name, auto_column, "completion_percent").value_or(0.0),
                   mark_on(table, name, columns).completion_percent});
  }
  return all;
}

TextRows auto_rows(const std::vector<AutoOnInput>& inputs) {
  constexpr double none = std::numeric_limits<double>::infinity();
  const auto text = [](double ratio) { return std::isfinite(ratio) ? fmt::format("{:.2f}", ratio) : "-"; };
  TextRows rows = {{"input", "best", "its ATE [m]", "auto [m]", "ratio", "tracked [%], most / auto"}};
  std::vector<double> ratios;
  for (const AutoOnInput& each : inputs) {
    ratios.push_back(each.ratio().value_or(none));
    rows.push_back({each.input, each.best, fmt::format("{:.4f}", each.best_error_m),
                    each.error_m ? fmt::format("{:.4f}", *each.error_m) : "failed", text(ratios.back()),
                    fmt::format("{:.1f} / {:.1f}", each.best_completion_percent, each.completion_percent)});
  }
  if (ratios.empty()) return rows;
  std::sort(ratios.begin(), ratios.end());
  const std::size_t half = ratios.size() / 2;
  const double median = ratios.size() % 2 == 1 ? ratios[half] : 0.5 * (ratios[half - 1] + ratios[half]);
  rows.push_back({"median", "", "", "", text(median), ""});
  rows.push_back({"worst", "", "", "", text(ratios.back()), ""});
  return rows;
}

}  // namespace rastro::cli
