// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/run_trace.h"

namespace rastro::cli {

/// The trace of one run of the table, or of an imported trajectory; or that a run gave no path to judge.
struct ColumnTrace {
  std::size_t input = 0;
  std::string column;
  std::uint64_t seed = 0;
  int repeat = 1;
  double completion_percent = 0.0;  ///< Frames tracked.
  double posed_percent = 0.0;       ///< Frames with a pose; all that is known of an import.
  RunTrace trace;
  bool has_path = true;  ///< False: the run failed or tracked nothing, and `trace` is empty.
};

/// Of every plain run and import on the inputs where any has a path.
std::vector<ColumnTrace> traces_of(const Comparison& comparison);

/// Of each column on the input the trace whose error is the median (of an even number the lower one).
std::vector<const ColumnTrace*> median_traces(const std::vector<ColumnTrace>& traces,
                                              const std::vector<std::string>& columns, std::size_t input);

/// The error of one column by that of another over the same inputs, seeds and repeats, and only over the frames that
/// both tracked: neither gains by giving up early. A run without a path is worse than any with one; where neither has
/// one, nothing tells them apart.
struct PairedDifference {
  std::string first, second;
  int pairs = 0;         ///< Inputs and seeds; repeats of one count as their median, as they are not independent.
  int first_better = 0;  ///< Of these.
  int runs = 0;          ///< That both columns have.
  int first_failed = 0, second_failed = 0;  ///< Of these, without a path.
  int left_out = 0;  ///< Of these: both have a path, but hardly a frame in common, so that nothing tells them apart.
  double median_ratio = 1.0;  ///< ATE of the first by that of the second; 0 where that gave no path in half of them.
  double p_value = 1.0;       ///< Wilcoxon's signed-rank test of the logarithms of the ratios.
  double adjusted_p = 1.0;    ///< After Holm, over all differences of the report.
  double first_completion = 0.0, second_completion = 0.0;  ///< Mean in percent, also of pairs without common frames.
  bool differs_in_alignment = false;  ///< An error after fitting the scale is not ranked with one in meters.

  bool is_known() const { return pairs > 0; }
  bool any_failed() const { return first_failed + second_failed > 0; }
  bool is_significant() const { return adjusted_p < 0.05; }
  /// Completions differ by so much that the errors alone do not rank the two.
  bool differs_in_completion() const;
  /// They do, and the one with the smaller error is the less complete one.
  bool is_ambiguous() const { return differs_in_completion() && first_completion < second_completion; }
};

/// "2 of 6 runs left out: too few frames in common"; empty where none is.
std::string left_out_text(const PairedDifference& difference);

/// Every two columns with at least one pair, the better one first. Behind them those whose runs are all left out:
/// nothing is known of them, and no test was made.
std::vector<PairedDifference> paired_differences(const std::vector<ColumnTrace>& traces,
                                                 const std::vector<std::string>& columns);

}  // namespace rastro::cli
