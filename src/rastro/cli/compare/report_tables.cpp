// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/report_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "rastro/cli/compare/alignment_choice.h"

namespace rastro::cli {
namespace {

/// Of this kind on the input; empty: none has an error.
std::string best_column(const Comparison& comparison, std::size_t index, const std::string& kind) {
  const ResultTable& table = comparison.table;
  const std::string& input = comparison.inputs[index].name;
  std::vector<std::string> columns;
  for (const std::string& column : table.columns_on(input)) {
    const auto known = comparison.column_kinds.find(column);
    if (known != comparison.column_kinds.end() && known->second == kind && table.median(input, column, "ate_m"))
      columns.push_back(column);
  }
  return best_on(table, input, ranked_together(comparison, index, columns));
}

std::string p_text(double p) { return p < 0.001 ? "< 0.001" : fmt::format("{:.3f}", p); }

/// "-" where the second gave no path in half of the pairs, and where there is no pair.
std::string ratio_text(const PairedDifference& difference) {
  return difference.is_known() && difference.median_ratio > 0.0 ? fmt::format("{:.2f}", difference.median_ratio) : "-";
}

std::string failures_of(const PairedDifference& difference) {
  return fmt::format("{} / {} of {}", difference.first_failed, difference.second_failed, difference.runs);
}

std::string verdict_on(const PairedDifference& difference) {
  if (!difference.is_known()) return "no ranking";
  if (difference.differs_in_alignment) return "no ranking: aligned differently";
  if (difference.is_ambiguous()) return "no ranking: completion differs";
  return difference.is_significant() ? "significant" : "may be chance";
}

std::string remark_on(const PairedDifference& difference) {
  const std::string left_out = left_out_text(difference);
  return verdict_on(difference) + (left_out.empty() ? "" : "; " + left_out);
}

/// Figures of the input with this prefix, in the order of their names.
std::vector<std::string> figures_with(const Comparison& comparison, const std::string& input,
                                      const std::string& prefix) {
  std::vector<std::string> names;
  for (const FinishedRun& run : comparison.runs) {
    if (comparison.inputs[run.what.input].name != input || !run.is_plain()) continue;
    for (const auto& [name, value] : run.result.scores.figures)
      if (name.starts_with(prefix) && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

std::string without_ends(const std::string& name, const std::string& prefix, const std::string& unit) {
  return name.substr(prefix.size(), name.size() - prefix.size() - unit.size());
}

TextRows rows_with(const Comparison& comparison, const std::string& input, const std::string& prefix,
                   const std::string& unit, double factor, int digits) {
  const auto figures = figures_with(comparison, input, prefix);
  TextRows rows = {{"method"}};
  for (const std::string& figure : figures) rows.front().push_back(without_ends(figure, prefix, unit));
  for (const std::string& column : comparison.table.columns_on(input)) {
    std::vector<std::string> row = {column};
    bool any = false;
    for (const std::string& figure : figures) {
      const auto value = comparison.table.median(input, column, figure);
      any |= value.has_value();
      row.push_back(value ? fmt::format("{:.{}f}", factor * *value, digits) : "-");
    }
    if (any) rows.push_back(std::move(row));
  }
  return rows;
}

std::string markdown_cell(const std::string& text) {
  std::string safe;
  for (const char letter : text) safe += letter == '|' ? std::string("\\|") : std::string(1, letter);
  return safe;
}

std::string markdown_table(const TextRows& rows) {
  std::string text;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    text += "|";
    for (const std::string& cell : rows[k]) text += fmt::format(" {} |", markdown_cell(cell));
    text += "\n";
    if (k > 0) continue;
    text += "|";
    for (std::size_t column = 0; column < rows[0].size(); ++column) text += column == 0 ? " --- |" : " ---: |";
    text += "\n";
  }
  return text + "\n";
}

std::string latex_text(const std::string& text) {
  std::string safe;
  for (const char letter : text) {
    if (letter == '%' || letter == '_' || letter == '&' || letter == '#' || letter == '$' || letter == '{' ||
        letter == '}')
      safe += '\\';
    if (letter == '<' || letter == '>')
      safe += fmt::format("${}$", letter);
    else
      safe += letter == '\\' ? ' ' : letter;
  }
  return safe;
}

std::string latex_table(const std::string& caption, const TextRows& rows) {
  std::string text =
      fmt::format("\\begin{{table}}\n\\centering\n\\caption{{{}}}\n\\begin{{tabular}}{{l{}}}\n\\toprule\n",
                  latex_text(caption), std::string(rows.front().size() - 1, 'r'));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::vector<std::string> cells;
    for (const std::string& cell : rows[k]) cells.push_back(latex_text(cell));
    text += fmt::format("{} \\\\\n{}", fmt::join(cells, " & "), k == 0 ? "\\midrule\n" : "");
  }
  return text + "\\bottomrule\n\\end{tabular}\n\\end{table}\n\n";
}

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char letter : text) quoted += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return quoted + "\"";
}

std::vector<std::string> figure_names(const Comparison& comparison) {
  std::vector<std::string> names;
  for (const FigureKind& figure : compare_figures()) names.push_back(figure.name);
  for (const CompareInput& input : comparison.inputs)
    for (const char* prefix : {"stage/", "length/"})
      for (const std::string& name : figures_with(comparison, input.name, prefix))
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  return names;
}

}  // namespace

Report report_of(const Comparison& comparison) {
  Report report{comparison, traces_of(comparison), {}, {}, {}, auto_on_inputs(comparison)};
  // What auto is compared with are runs of the same methods: it has a table of its own.
  std::vector<std::string> columns = comparison.table.columns();
  std::erase(columns, auto_column);
  report.differences = paired_differences(report.traces, columns);
  report.advice = use_case_advice(comparison, report.differences);
  if (comparison.paper) report.paper = paper_tables(comparison, report.traces);
  return report;
}

TextRows summary_rows(const Comparison& comparison) {
  TextRows rows = {{"input", "sensor", "method", "aligned", "ATE [m]", "tracked [%]", "ms/frame"}};
  const ResultTable& table = comparison.table;
  for (std::size_t k = 0; k < comparison.inputs.size(); ++k) {
    const std::string& input = comparison.inputs[k].name;
    for (const char* kind : {"mono", "stereo", "depth", "laser"}) {
      const std::string column = best_column(comparison, k, kind);
      if (column.empty()) continue;
      const auto cell = [&](const char* figure) {
        return figure_text(compare_figure(figure), table.median(input, column, figure));
      };
      const int failed = table.runs_without_error(input, column);
      const std::string without =
          failed > 0 ? fmt::format(" ({} of {} failed)", failed, table.runs(input, column)) : "";
      rows.push_back({input, kind, column, alignment_text(comparison, k, column), cell("ate_m") + without,
                      cell("completion_percent"), cell("frame_ms")});
    }
  }
  return rows;
}

TextRows difference_rows(const std::vector<PairedDifference>& differences) {
  TextRows rows = {
      {"smaller error", "than", "ratio", "better in", "p", "p (Holm)", "no path", "tracked [%]", "verdict"}};
  for (const PairedDifference& each : differences)
    rows.push_back({each.first, each.second, ratio_text(each), fmt::format("{} of {}", each.first_better, each.pairs),
                    each.is_known() ? p_text(each.p_value) : "-", each.is_known() ? p_text(each.adjusted_p) : "-",
                    failures_of(each), fmt::format("{:.0f} / {:.0f}", each.first_completion, each.second_completion),
                    remark_on(each)});
  return rows;
}

TextRows strength_rows(const Comparison& comparison) {
  TextRows rows = {{"input", "method", "disturbance", "holds", "fails at", "how", "recovery [s]"}};
  for (const StrengthCurve& curve : comparison.strengths) {
    std::string holds = "-", fails = "-", how = "holds all that were tried", recovery = "-";
    for (const StrengthStep& step : curve.steps) {
      (step.failure.empty() ? holds : fails) = step.assignment;
      if (!step.failure.empty()) how = step.failure + (step.warned ? ", and warns" : "");
      if (step.recovery_s) recovery = fmt::format("{:.2f}", *step.recovery_s);
    }
    if (!curve.steps.empty())
      rows.push_back(
          {comparison.inputs[curve.input].name, curve.column, curve.disturbance, holds, fails, how, recovery});
  }
  return rows;
}

TextRows stage_rows(const Comparison& comparison, const std::string& input) {
  return rows_with(comparison, input, "stage/", "_ms", 1.0, 2);
}

TextRows length_rows(const Comparison& comparison, const std::string& input) {
  return rows_with(comparison, input, "length/", "_m", 1e3, 1);
}

std::string report_as_markdown(const Report& report) {
  const Comparison& comparison = report.comparison;
  std::string text = fmt::format("# Comparison\n\n`{}`\n\n", comparison.command);
  if (const std::string part = interruption_text(comparison); !part.empty())
    text += fmt::format("**This comparison was {}: medians and advice are of these alone.**\n\n", part);
  for (const UseCaseAdvice& advice : report.advice) text += fmt::format("**{}.** {}\n\n", advice.title, advice.text);
  text += "## The best of each sensor\n\n" + markdown_table(summary_rows(comparison));
  if (!report.by_auto.empty()) text += "## What auto makes of it\n\n" + markdown_table(auto_rows(report.by_auto));
  for (const PaperTable& table : report.paper) {
    text += fmt::format("## {}\n\n{}", table.title, markdown_table(table.rows));
    if (!table.note.empty()) text += table.note + "\n\n";
  }
  for (std::size_t k = 0; k < comparison.inputs.size(); ++k) {
    const std::string& name = comparison.inputs[k].name;
    text += fmt::format("## {}\n\n{}", name, markdown_table(rows_on(comparison, k, false)));
    const TextRows stages = stage_rows(comparison, name), lengths = length_rows(comparison, name);
    if (lengths.size() > 1) text += "Errors of the named lengths, mm:\n\n" + markdown_table(lengths);
    if (stages.size() > 1) text += "Time by stage, ms per frame:\n\n" + markdown_table(stages);
  }
  text += values_text(comparison) + "\n\n";
  if (!report.differences.empty())
    text += "## Differences over the frames that both track\n\n" + markdown_table(difference_rows(report.differences));
  if (!comparison.strengths.empty()) text += "## Disturbances\n\n" + markdown_table(strength_rows(comparison));
  for (const FinishedRun& run : comparison.runs)
    if (run.failed()) text += fmt::format("- failed: `{}`: {}\n", run.run_command, run.result.failure);
  for (const std::string& refused : comparison.refused) text += fmt::format("- not run: {}\n", refused);
  return text;
}

std::string report_as_latex(const Report& report) {
  const Comparison& comparison = report.comparison;
  std::string text = "% Needs \\usepackage{booktabs}. " + comparison.command + "\n";
  if (const std::string load = load_text(comparison); !load.empty()) text += "% " + load + "\n";
  for (const PaperTable& table : report.paper) text += latex_table(table.title, table.rows);
  for (std::size_t k = 0; k < comparison.inputs.size(); ++k)
    text += latex_table(comparison.inputs[k].name + ": median over seeds and repeats, worst in parentheses",
                        rows_on(comparison, k, false));
  if (!report.differences.empty())
    text += latex_table("ATE over the frames that both track, paired by input and seed; Wilcoxon signed-rank test",
                        difference_rows(report.differences));
  if (!comparison.strengths.empty())
    text += latex_table("Strength of a disturbance at which tracking is lost or the error doubles",
                        strength_rows(comparison));
  return text;
}

std::string report_as_csv(const Comparison& comparison) {
  std::string text = "input,method,seed,repeat,figure,value,command\n";
  for (const std::string& figure : figure_names(comparison))
    for (const std::string& input : comparison.table.inputs())
      for (const std::string& column : comparison.table.columns_on(input))
        for (const Sample& sample : comparison.table.samples(input, column, figure))
          text += fmt::format("{},{},{},{},{},{:.9g},{}\n", csv_cell(input), csv_cell(column), sample.seed,
                              sample.repeat, csv_cell(figure), sample.value, csv_cell(sample.command));
  return text;
}

}  // namespace rastro::cli
