// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/auto_choice.h"

#include <fmt/format.h>

#include <algorithm>

namespace rastro::cli {
namespace {

constexpr const char* auto_column = "auto";

bool is_slam(const Comparison& comparison, const std::string& column) {
  return std::any_of(comparison.runs.begin(), comparison.runs.end(), [&](const FinishedRun& run) {
    return run.what.column == column && run.run_command.starts_with("rastro slam ");
  });
}

/// Errors below that are rounding.
constexpr double smallest_error_m = 1e-6;

std::vector<std::string> rivals(const Comparison& comparison, std::size_t input) {
  const std::string& name = comparison.inputs[input].name;
  std::vector<std::string> columns;
  for (const std::string& column : comparison.table.columns_on(name))
    if (column != auto_column && is_slam(comparison, column) && comparison.table.median(name, column, "ate_m") &&
        alignment_text(comparison, input, column) == alignment_text(comparison, input, auto_column))
      columns.push_back(column);
  return columns;
}

}  // namespace

std::vector<AutoOnInput> auto_on_inputs(const Comparison& comparison) {
  std::vector<AutoOnInput> all;
  const ResultTable& table = comparison.table;
  for (std::size_t k = 0; k < comparison.inputs.size(); ++k) {
    const std::string& name = comparison.inputs[k].name;
    const auto error = table.median(name, auto_column, "ate_m");
    const std::vector<std::string> columns = rivals(comparison, k);
    const std::string best = best_on(table, name, columns);
    if (!error || best.empty()) continue;
    all.push_back({name, best, std::max(*error, smallest_error_m),
                   std::max(*table.median(name, best, "ate_m"), smallest_error_m),
                   table.median(name, auto_column, "completion_percent").value_or(0.0),
                   mark_on(table, name, columns).completion_percent});
  }
  return all;
}

TextRows auto_rows(const std::vector<AutoOnInput>& inputs) {
  TextRows rows = {{"input", "best", "its ATE [m]", "auto [m]", "ratio", "tracked [%], most / auto"}};
  std::vector<double> ratios;
  for (const AutoOnInput& each : inputs) {
    rows.push_back({each.input, each.best, fmt::format("{:.4f}", each.best_error_m),
                    fmt::format("{:.4f}", each.error_m), fmt::format("{:.2f}", each.ratio()),
                    fmt::format("{:.1f} / {:.1f}", each.best_completion_percent, each.completion_percent)});
    ratios.push_back(each.ratio());
  }
  if (ratios.empty()) return rows;
  std::sort(ratios.begin(), ratios.end());
  const std::size_t half = ratios.size() / 2;
  const double median = ratios.size() % 2 == 1 ? ratios[half] : 0.5 * (ratios[half - 1] + ratios[half]);
  rows.push_back({"median", "", "", "", fmt::format("{:.2f}", median), ""});
  rows.push_back({"worst", "", "", "", fmt::format("{:.2f}", ratios.back()), ""});
  return rows;
}

}  // namespace rastro::cli
