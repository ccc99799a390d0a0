// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/report_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

namespace rastro::cli {
namespace {

std::string in_words(const std::string& alignment) {
  if (alignment == "se3") return "SE3";
  if (alignment == "sim3") return "Sim3";
  return alignment.empty() ? "-" : alignment;
}

std::string cell_of(const ResultTable& table, const std::string& input, const std::string& column,
                    const FigureKind& figure) {
  const std::string median = figure_text(figure, table.median(input, column, figure.name));
  const std::string worst = figure_text(figure, table.worst(input, column, figure));
  return worst == median ? median : fmt::format("{} ({})", median, worst);
}

std::string runs_text(const Comparison& comparison, std::size_t input, const std::string& column) {
  int runs = 0, failed = 0;
  for (const FinishedRun& run : comparison.runs) {
    if (!run.is_plain() || run.what.input != input || run.what.column != column) continue;
    ++runs;
    failed += run.failed() ? 1 : 0;
  }
  if (runs == 0) return "file";
  return failed == 0 ? fmt::format("{}", runs) : fmt::format("{}, {} failed", runs, failed);
}

std::string facts_text(const InputFacts& facts) {
  std::vector<std::string> has;
  if (facts.has_depth) has.emplace_back("images with depth");
  if (facts.has_right) has.emplace_back("stereo images");
  if (facts.has_image && !facts.has_depth && !facts.has_right) has.emplace_back("one camera");
  if (facts.has_scan) has.emplace_back("laser scans");
  if (facts.has_odometry) has.emplace_back("wheel odometry");
  std::string text = fmt::format("{}", fmt::join(has, ", "));
  if (facts.path_m > 0.0) text += fmt::format("; path {:.1f} m, {:.1f} m/s", facts.path_m, facts.speed_m_s);
  return facts.has_ground_truth ? text : text + "; no ground truth";
}

std::string failures_text(const Comparison& comparison) {
  std::string text;
  for (const FinishedRun& run : comparison.runs)
    if (run.failed())
      text += fmt::format("failed: {}: {}\n  {}\n", run.result.entry, run.result.failure, run.run_command);
  for (const std::string& refused : comparison.refused) text += fmt::format("not run: {}\n", refused);
  return text;
}

}  // namespace

std::string alignment_text(const Comparison& comparison, std::size_t input, const std::string& column) {
  std::set<std::string> all;
  for (const FinishedRun& run : comparison.runs)
    if (run.is_plain() && run.what.input == input && run.what.column == column && !run.failed())
      all.insert(in_words(run.result.scores.alignment));
  for (const ImportedTrajectory& import : comparison.imported)
    if (import.input == input && import.column == column) all.insert(in_words(import.alignment));
  return all.empty() ? "-" : fmt::format("{}", fmt::join(all, ", "));
}

std::vector<const FigureKind*> figures_on(const ResultTable& table, const std::string& input) {
  std::vector<const FigureKind*> figures;
  const std::vector<std::string> columns = table.columns_on(input);
  for (const FigureKind& figure : compare_figures()) {
    const auto has = [&](const std::string& column) { return !table.samples(input, column, figure.name).empty(); };
    if (std::any_of(columns.begin(), columns.end(), has)) figures.push_back(&figure);
  }
  return figures;
}

TextRows rows_on(const Comparison& comparison, std::size_t input, bool all_figures) {
  const std::string& name = comparison.inputs[input].name;
  auto figures = figures_on(comparison.table, name);
  std::erase_if(figures, [&](const FigureKind* figure) { return !all_figures && !figure->in_text; });
  TextRows rows = {{"method", "runs", "aligned"}};
  for (const FigureKind* figure : figures) rows.front().push_back(figure->title);
  for (const std::string& column : comparison.table.columns_on(name)) {
    rows.push_back({column, runs_text(comparison, input, column), alignment_text(comparison, input, column)});
    for (const FigureKind* figure : figures) rows.back().push_back(cell_of(comparison.table, name, column, *figure));
  }
  return rows;
}

std::string load_text(const Comparison& comparison) {
  const int runs = runs_at_once(comparison);
  if (runs == 1) return "";
  return fmt::format(
      "Times are of {} runs at once on this machine: alone a run has more of it. '--jobs 1' measures that.", runs);
}

std::string values_text(const Comparison& comparison) {
  std::string text = "Each value is the median over seeds and repeats, the worst in parentheses where it differs.";
  if (std::any_of(comparison.runs.begin(), comparison.runs.end(),
                  [](const FinishedRun& run) { return run.is_plain() && run.failed(); }))
    text += " Runs that failed count in 'complete', as 0 %, and in no other figure.";
  const std::string load = load_text(comparison);
  return load.empty() ? text : text + " " + load;
}

std::string aligned_text(const TextRows& rows) {
  std::vector<std::size_t> widths(rows.empty() ? 0 : rows.front().size(), 0);
  for (const auto& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  std::string text;
  for (const auto& row : rows) {
    text += fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t k = 1; k < row.size(); ++k) text += fmt::format("  {:>{}}", row[k], widths[k]);
    text += "\n";
  }
  return text;
}

std::string comparison_as_text(const Comparison& comparison) {
  std::string text;
  for (std::size_t k = 0; k < comparison.inputs.size(); ++k) {
    const CompareInput& input = comparison.inputs[k];
    text += fmt::format("{}{} ({})\n{}", k == 0 ? "" : "\n", input.name, facts_text(input.facts),
                        aligned_text(rows_on(comparison, k, false)));
  }
  if (const std::string part = interruption_text(comparison); !part.empty())
    text += fmt::format("\n{}: medians and advice are of these alone.\n", part);
  return text + "\n" + values_text(comparison) + "\n" + failures_text(comparison);
}

}  // namespace rastro::cli
