// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/use_cases.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include "rastro/cli/compare/alignment_choice.h"

namespace rastro::cli {
namespace {

constexpr double fast_m_s = 3.0;
constexpr double smallest_error_m = 1e-6;

struct UseCase {
  std::string title, judged_by;
  std::function<bool(const InputFacts&)> holds;
  std::set<std::string> kinds;  ///< Of sensors that a method uses.
};

bool is_slow_camera(const InputFacts& facts) { return facts.has_image && facts.speed_m_s < fast_m_s; }

const std::vector<UseCase>& use_cases() {
  static const std::vector<UseCase> cases = {
      {"Hand-held depth camera",
       "inputs with depth images",
       [](const InputFacts& f) { return f.has_depth; },
       {"depth"}},
      {"Robot with a laser", "inputs with laser scans", [](const InputFacts& f) { return f.has_scan; }, {"laser"}},
      {"Car",
       "inputs of cameras without depth that move at 3 m/s or more",
       [](const InputFacts& f) { return f.has_image && !f.has_depth && f.speed_m_s >= fast_m_s; },
       {"mono", "stereo"}},
      {"Drone",
       "inputs of cameras without depth that move at less than 3 m/s",
       [](const InputFacts& f) { return is_slow_camera(f) && !f.has_depth; },
       {"mono", "stereo"}},
      {"Phone video", "methods of one camera on inputs that move at less than 3 m/s", is_slow_camera, {"mono"}}};
  return cases;
}

/// A method over those inputs of a use case on which it ran and an error can be measured.
struct Candidate {
  std::string column;
  double completion = 0.0;  ///< Mean over the inputs of the medians.
  double missing = 0.0;     ///< Mean of how far that is below the mark of the input, points.
  double log_error = 0.0;   ///< Mean logarithm of the error by the mark of the input, where it has one.
  std::vector<std::size_t> inputs = {};
  int failed = 0;                 ///< Of these, inputs on which half of its runs or more gave no path.
  int runs = 0, failed_runs = 0;  ///< On these inputs; the latter gave no path.

  bool is_out() const { return missing > completion_points || log_error > std::log(most_error_factor); }
};

std::vector<std::string> columns_of(const Comparison& comparison, const UseCase& use) {
  std::vector<std::string> columns;
  for (const std::string& column : comparison.table.columns()) {
    const auto kind = comparison.column_kinds.find(column);
    if (kind != comparison.column_kinds.end() && use.kinds.contains(kind->second)) columns.push_back(column);
  }
  return columns;
}

Candidate candidate_of(const Comparison& comparison, const std::vector<std::size_t>& inputs,
                       const std::vector<std::string>& columns, const std::string& column) {
  Candidate candidate;
  candidate.column = column;
  const ResultTable& table = comparison.table;
  for (const std::size_t input : inputs) {
    const std::string& name = comparison.inputs[input].name;
    const std::vector<std::string> rivals = ranked_together(comparison, input, columns);
    if (std::find(rivals.begin(), rivals.end(), column) == rivals.end()) continue;
    const MarkOnInput mark = mark_on(table, name, rivals);
    const auto completed = table.median(name, column, "completion_percent");
    if (!mark.error_m || !completed) continue;
    const auto error = table.median_error(name, column);
    const double completion = error ? *completed : 0.0;
    candidate.inputs.push_back(input);
    candidate.completion += completion;
    candidate.missing += mark.completion_percent - completion;
    candidate.failed += error ? 0 : 1;
    candidate.runs += table.runs(name, column), candidate.failed_runs += table.runs_without_error(name, column);
    if (error)
      candidate.log_error += std::log(std::max(*error, smallest_error_m) / std::max(*mark.error_m, smallest_error_m));
  }
  const auto count = static_cast<double>(candidate.inputs.size()), judged = count - candidate.failed;
  if (judged < 1.0) return {.column = column, .runs = candidate.runs, .failed_runs = candidate.failed_runs};
  candidate.completion /= count, candidate.missing /= count, candidate.log_error /= judged;
  return candidate;
}

/// Recommended first; then by error, those that complete too little last.
std::vector<Candidate> ranked(std::vector<Candidate> candidates) {
  std::erase_if(candidates, [](const Candidate& each) { return each.inputs.empty(); });
  std::stable_sort(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) {
    return a.is_out() != b.is_out() ? b.is_out() : a.log_error < b.log_error;
  });
  return candidates;
}

std::string range_text(const Comparison& comparison, const Candidate& candidate, const char* figure_name) {
  const FigureKind& figure = compare_figure(figure_name);
  std::optional<double> low, high;
  for (const std::size_t input : candidate.inputs) {
    const auto value = comparison.table.median(comparison.inputs[input].name, candidate.column, figure.name);
    if (!value || !std::isfinite(*value)) continue;
    low = std::min(low.value_or(*value), *value), high = std::max(high.value_or(*value), *value);
  }
  const std::string from = figure_text(figure, low), to = figure_text(figure, high);
  return from == to ? from : from + " to " + to;
}

std::string expectation_text(const Comparison& comparison, const Candidate& best) {
  std::string text = fmt::format(
      "Expect {:.0f} % of the frames tracked, an ATE of {} m, a drift of {} % of the path, {} ms a frame on this "
      "machine{}",
      best.completion, range_text(comparison, best, "ate_m"), range_text(comparison, best, "drift_percent"),
      range_text(comparison, best, "frame_ms"),
      runs_at_once(comparison) > 1 ? fmt::format(" with {} runs at once", runs_at_once(comparison)) : "");
  if (const std::string inside = range_text(comparison, best, "inside_position_percent"); inside != "-")
    text += fmt::format(", and {} % of the positions inside their 95 % ellipse", inside);
  if (const std::string length = range_text(comparison, best, "length_max_m"); length != "-")
    text += fmt::format("; the worst of the named lengths is {} m off", length);
  std::vector<std::string> too_slow;
  for (const std::size_t input : best.inputs) {
    const CompareInput& of = comparison.inputs[input];
    const auto ms = comparison.table.median(of.name, best.column, "frame_ms");
    if (ms && of.facts.rate_hz > 0.0 && *ms > 1e3 / of.facts.rate_hz)
      too_slow.push_back(fmt::format("{} ({:.0f} frames a second)", of.name, of.facts.rate_hz));
  }
  if (!too_slow.empty()) text += fmt::format("; it does not keep up with {}", fmt::join(too_slow, ", "));
  if (best.failed_runs > 0) text += "; errors and times are of the runs that gave a path";
  return text + ".";
}

std::string difference_text(const PairedDifference& difference) {
  if (!difference.is_known()) return "The two are not compared: their runs have too few tracked frames in common";
  const std::string is = difference.median_ratio > 0.0
                             ? fmt::format("the error of {} is {:.2f} times that of {}", difference.first,
                                           difference.median_ratio, difference.second)
                             : fmt::format("{} is before {}, which gave no path in half of the pairs or more",
                                           difference.first, difference.second);
  const std::string failed = difference.any_failed()
                                 ? fmt::format("; no path in {} and {} of {} runs, which counts as worse",
                                               difference.first_failed, difference.second_failed, difference.runs)
                                 : "";
  const std::string left_out = difference.left_out > 0 ? "; " + left_out_text(difference) : "";
  return fmt::format("Over the frames that both track, {} ({} of {} pairs; p = {:.2g}: {}{}{})", is,
                     difference.first_better, difference.pairs, difference.adjusted_p,
                     difference.is_significant() ? "a difference" : "may be chance", failed, left_out);
}

/// "; it gave no path in 2 of 6 runs"; empty where all gave one.
std::string failures_of(const Candidate& candidate) {
  if (candidate.failed_runs == 0) return "";
  return fmt::format("; it gave no path in {} of {} runs", candidate.failed_runs, candidate.runs);
}

std::string next_text(const std::vector<Candidate>& candidates, const std::vector<PairedDifference>& differences) {
  if (candidates.size() < 2) return "";
  const std::string &best = candidates[0].column, &next = candidates[1].column;
  std::string text =
      fmt::format(" Next is {}, with {:.0f} % tracked{}.", next, candidates[1].completion, failures_of(candidates[1]));
  for (const PairedDifference& difference : differences)
    if (!difference.differs_in_alignment && ((difference.first == best && difference.second == next) ||
                                             (difference.first == next && difference.second == best)))
      text += " " + difference_text(difference) + ", over all inputs of this report.";
  return text;
}

std::string why_text(const Candidate& best, std::size_t candidates, const std::string& inputs) {
  const std::string failed = failures_of(best);
  if (candidates == 1)
    return fmt::format("{}: the only method for it that was named and gave a path, on {}{}. ", best.column, inputs,
                       failed);
  if (best.is_out())
    return fmt::format(
        "No method for it is both complete and accurate (within {:.0f} points of the most complete accurate one, at "
        "most {:.0f} times the smallest error). {}: of the {} methods, judged on {}, it has the smallest error, and "
        "tracks {:.0f} points less{}. ",
        completion_points, most_error_factor, best.column, candidates, inputs, best.missing, failed);
  const double ratio = std::exp(best.log_error);
  return fmt::format(
      "{}: of the {} methods for it, judged on {}, it has the smallest error of those that track about as many frames "
      "as the most complete accurate one (within {:.0f} points; accurate: at most {:.0f} times the smallest "
      "error){}{}. ",
      best.column, candidates, inputs, completion_points, most_error_factor,
      ratio > 1.005 ? fmt::format(", {:.2f} times the smallest on each input", ratio) : "", failed);
}

/// Where the runs of the best method are too short to tell much.
std::string shortness_text(const Comparison& comparison, const Candidate& best) {
  constexpr std::int64_t enough_frames = 200;
  std::int64_t frames = 0;
  for (const FinishedRun& run : comparison.runs)
    if (run.what.column == best.column && run.is_plain()) frames += run.result.scores.frames;
  if (frames == 0 || frames >= enough_frames) return "";
  return fmt::format(" With {} frames in all this is a first look: more of the recording tells more.", frames);
}

/// Who is not ranked since there is nothing to rank it by.
std::string without_path_text(const std::vector<Candidate>& candidates) {
  std::vector<std::string> names;
  for (const Candidate& each : candidates)
    if (each.inputs.empty() && each.failed_runs > 0)
      names.push_back(fmt::format("{} ({} of {})", each.column, each.failed_runs, each.runs));
  if (names.empty()) return "";
  return fmt::format(" Not ranked, as they gave no path in half of their runs or more: {}.", fmt::join(names, ", "));
}

/// How the best one is aligned where that needs a word, and who was not ranked with it for that.
std::string scale_text(const Comparison& comparison, const std::vector<std::size_t>& inputs, const Candidate& best,
                       const std::vector<std::string>& columns) {
  const auto is_fitted = [&](std::size_t input) { return is_up_to_scale(comparison, input, best.column); };
  if (std::any_of(best.inputs.begin(), best.inputs.end(), is_fitted))
    return " It is up to scale: its error is after fitting the scale.";
  std::vector<std::string> fitted;
  for (const std::string& column : columns)
    if (std::any_of(inputs.begin(), inputs.end(),
                    [&](std::size_t input) { return is_up_to_scale(comparison, input, column); }))
      fitted.push_back(column);
  if (fitted.empty()) return "";
  return fmt::format(" Not ranked with it, as their error is after fitting the scale: {}.", fmt::join(fitted, ", "));
}

std::string advice_on(const Comparison& comparison, const std::vector<std::size_t>& inputs, const UseCase& use,
                      const std::vector<PairedDifference>& differences) {
  const std::vector<std::string> columns = columns_of(comparison, use);
  std::vector<Candidate> candidates;
  for (const std::string& column : columns) candidates.push_back(candidate_of(comparison, inputs, columns, column));
  const std::string without_path = without_path_text(candidates);
  candidates = ranked(std::move(candidates));
  if (columns.empty()) return "Inputs of this kind are here, but no method for it was run.";
  if (candidates.empty()) return "Inputs of this kind are here, but no run with an error to judge it by.";
  const Candidate& best = candidates.front();
  std::vector<std::string> names;
  for (const std::size_t input : best.inputs) names.push_back(comparison.inputs[input].name);
  return why_text(best, candidates.size(), fmt::format("{}", fmt::join(names, ", "))) +
         expectation_text(comparison, best) + scale_text(comparison, inputs, best, columns) +
         next_text(candidates, differences) + without_path + shortness_text(comparison, best);
}

}  // namespace

std::vector<UseCaseAdvice> use_case_advice(const Comparison& comparison,
                                           const std::vector<PairedDifference>& differences) {
  std::vector<UseCaseAdvice> all;
  for (const UseCase& use : use_cases()) {
    std::vector<std::size_t> inputs;
    for (std::size_t k = 0; k < comparison.inputs.size(); ++k)
      if (!comparison.inputs[k].is_special && use.holds(comparison.inputs[k].facts)) inputs.push_back(k);
    all.push_back({use.title, inputs.empty() ? "No data for this here: it takes " + use.judged_by + "."
                                             : advice_on(comparison, inputs, use, differences) + " Judged by " +
                                                   use.judged_by + "."});
  }
  return all;
}

}  // namespace rastro::cli
