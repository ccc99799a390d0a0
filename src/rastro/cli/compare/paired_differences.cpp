// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/paired_differences.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/evaluate/paired_significance.h"

namespace rastro::cli {
namespace {

constexpr double smallest_error_m = 1e-6;  ///< Below it two errors are equal.

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

constexpr double failure = std::numeric_limits<double>::infinity();  ///< Logarithm of an error that is worse than any.

/// Failures of one column against those of the other cancel out; the mean of these would be nan.
double middle_of(std::vector<double> logs) {
  if (logs.empty()) return 0.0;
  std::sort(logs.begin(), logs.end());
  const double lower = logs[(logs.size() - 1) / 2], upper = logs[logs.size() / 2];
  return lower == -failure && upper == failure ? 0.0 : 0.5 * (lower + upper);
}

/// The values of the pairs of two columns.
struct Pairs {
  /// By input and seed; infinite where one alone has a path.
  std::map<std::pair<std::size_t, std::uint64_t>, std::vector<double>> log_ratios;
  int first_failed = 0, second_failed = 0, left_out = 0;
  std::vector<double> first_completions, second_completions;
  bool differ_in_alignment = false;
};

bool is_import(const ColumnTrace& each) { return each.has_path && each.trace.frames.empty(); }

void add_pair(const ColumnTrace& first, const ColumnTrace& second, Pairs& pairs) {
  const bool by_poses = is_import(first) || is_import(second);
  pairs.first_completions.push_back(by_poses ? first.posed_percent : first.completion_percent);
  pairs.second_completions.push_back(by_poses ? second.posed_percent : second.completion_percent);
  pairs.first_failed += first.has_path ? 0 : 1, pairs.second_failed += second.has_path ? 0 : 1;
  if (!first.has_path || !second.has_path) {
    if (first.has_path != second.has_path)
      pairs.log_ratios[{first.input, first.seed}].push_back(first.has_path ? -failure : failure);
    return;
  }
  const auto errors = errors_on_common_frames(first.trace, second.trace);
  if (!errors) {  // they count in the completion nevertheless
    ++pairs.left_out;
    return;
  }
  const double ratio = std::max(errors->first_m, smallest_error_m) / std::max(errors->second_m, smallest_error_m);
  pairs.log_ratios[{first.input, first.seed}].push_back(std::log(ratio));
  pairs.differ_in_alignment |= first.trace.alignment != second.trace.alignment;
}

Pairs pairs_of(const std::vector<ColumnTrace>& traces, const std::string& first, const std::string& second) {
  Pairs pairs;
  for (const ColumnTrace& a : traces) {
    if (a.column != first) continue;
    for (const ColumnTrace& b : traces)
      if (b.column == second && b.input == a.input && b.seed == a.seed && b.repeat == a.repeat) add_pair(a, b, pairs);
  }
  return pairs;
}

PairedDifference difference_of(const Pairs& pairs, const std::string& first, const std::string& second) {
  std::vector<double> logs;
  for (const auto& [pair, repeats] : pairs.log_ratios) logs.push_back(middle_of(repeats));
  PairedDifference difference;
  difference.first = first, difference.second = second;
  difference.pairs = static_cast<int>(logs.size());
  difference.median_ratio = std::exp(middle_of(logs));
  difference.p_value = signed_rank_p_value(logs);
  difference.first_better = static_cast<int>(std::count_if(logs.begin(), logs.end(), [](double x) { return x < 0.0; }));
  difference.runs = static_cast<int>(pairs.first_completions.size());
  difference.first_failed = pairs.first_failed, difference.second_failed = pairs.second_failed;
  difference.left_out = pairs.left_out;
  difference.first_completion = mean_of(pairs.first_completions);
  difference.second_completion = mean_of(pairs.second_completions);
  difference.differs_in_alignment = pairs.differ_in_alignment;
  return difference;
}

/// The same with the columns exchanged.
PairedDifference turned(const PairedDifference& difference, const Pairs& pairs) {
  PairedDifference other = difference;
  std::swap(other.first, other.second);
  std::swap(other.first_completion, other.second_completion);
  std::swap(other.first_failed, other.second_failed);
  other.median_ratio = 1.0 / difference.median_ratio;
  other.first_better = 0;
  for (const auto& [pair, repeats] : pairs.log_ratios) other.first_better += middle_of(repeats) > 0.0 ? 1 : 0;
  return other;
}

double percent(std::int64_t some, std::int64_t all) {
  return all > 0 ? 100.0 * static_cast<double>(some) / static_cast<double>(all) : 0.0;
}

/// nullopt where errors are judged by something else than poses, or not at all.
std::optional<ColumnTrace> trace_of(const FinishedRun& run, const Comparison& comparison, TraceReader& reader) {
  if (!run.is_plain() || run.ground_truth.empty()) return std::nullopt;
  const RunScores& scores = run.result.scores;
  ColumnTrace each{run.what.input,
                   run.what.column,
                   run.seed,
                   run.what.repeat,
                   percent(scores.tracked, scores.frames),
                   percent(scores.posed, scores.frames),
                   {},
                   false};
  if (run.failed()) each.completion_percent = each.posed_percent = 0.0;
  if (run.failed() || !scores.ate_m) return each;
  try {
    auto trace = reader.read(run.folder.string(), run.ground_truth, scores.alignment,
                             comparison.inputs[run.what.input].frames());
    if (!trace) return std::nullopt;
    each.trace = std::move(*trace), each.has_path = true;
    return each;
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Nothing is known of methods on an input that none of them could do.
void forget_inputs_without_paths(std::vector<ColumnTrace>& traces) {
  std::set<std::size_t> inputs;
  for (const ColumnTrace& each : traces)
    if (each.has_path) inputs.insert(each.input);
  std::erase_if(traces, [&](const ColumnTrace& each) { return !inputs.contains(each.input); });
}

}  // namespace

bool PairedDifference::differs_in_completion() const {
  constexpr double points = 5.0;
  return std::abs(first_completion - second_completion) > points;
}

std::string left_out_text(const PairedDifference& difference) {
  if (difference.left_out == 0) return "";
  return fmt::format("{} of {} runs left out: too few frames in common", difference.left_out, difference.runs);
}

std::vector<ColumnTrace> traces_of(const Comparison& comparison) {
  std::vector<ColumnTrace> traces;
  TraceReader reader;
  for (const FinishedRun& run : comparison.runs)
    if (auto trace = trace_of(run, comparison, reader)) traces.push_back(std::move(*trace));
  for (const ImportedTrajectory& import : comparison.imported) {
    const CompareInput& input = comparison.inputs[import.input];
    auto trace = reader.read(import.trajectory, import.ground_truth, import.alignment, input.frames(), import.of_body);
    if (!trace) continue;
    const double posed = trace->posed_percent(input.facts.frames);
    traces.push_back({import.input, import.column, import.seed, 1, posed, posed, std::move(*trace)});
  }
  forget_inputs_without_paths(traces);
  return traces;
}

std::vector<const ColumnTrace*> median_traces(const std::vector<ColumnTrace>& traces,
                                              const std::vector<std::string>& columns, std::size_t input) {
  std::vector<const ColumnTrace*> chosen;
  for (const std::string& column : columns) {
    std::vector<const ColumnTrace*> all;
    for (const ColumnTrace& each : traces)
      if (each.input == input && each.column == column && each.has_path) all.push_back(&each);
    if (all.empty()) continue;
    std::stable_sort(all.begin(), all.end(), [](const ColumnTrace* a, const ColumnTrace* b) {
      return a->trace.scores.ate_m->rmse < b->trace.scores.ate_m->rmse;
    });
    chosen.push_back(all[(all.size() - 1) / 2]);
  }
  return chosen;
}

std::vector<PairedDifference> paired_differences(const std::vector<ColumnTrace>& traces,
                                                 const std::vector<std::string>& columns) {
  std::vector<PairedDifference> all, unknown;
  std::vector<double> p_values;
  for (std::size_t first = 0; first < columns.size(); ++first) {
    for (std::size_t second = first + 1; second < columns.size(); ++second) {
      const Pairs pairs = pairs_of(traces, columns[first], columns[second]);
      if (pairs.log_ratios.empty() && pairs.left_out == 0) continue;
      const PairedDifference difference = difference_of(pairs, columns[first], columns[second]);
      if (!difference.is_known()) {
        unknown.push_back(difference);
        continue;
      }
      all.push_back(difference.median_ratio > 1.0 ? turned(difference, pairs) : difference);
      p_values.push_back(difference.p_value);
    }
  }
  const std::vector<double> adjusted = holm_adjusted(p_values);
  for (std::size_t k = 0; k < all.size(); ++k) all[k].adjusted_p = adjusted[k];
  all.insert(all.end(), unknown.begin(), unknown.end());
  return all;
}

}  // namespace rastro::cli
