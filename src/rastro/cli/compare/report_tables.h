// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/auto_choice.h"
#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/paired_differences.h"
#include "rastro/cli/compare/paper_tables.h"
#include "rastro/cli/compare/report_text.h"
#include "rastro/cli/compare/use_cases.h"

namespace rastro::cli {

/// A comparison with what is derived from it: what every report of it says.
struct Report {
  const Comparison& comparison;
  std::vector<ColumnTrace> traces;
  std::vector<PairedDifference> differences;
  std::vector<UseCaseAdvice> advice;
  std::vector<PaperTable> paper;     ///< Empty without Comparison::paper.
  std::vector<AutoOnInput> by_auto;  ///< Empty where it was not run.
};

Report report_of(const Comparison& comparison);

/// Of every input and kind of sensor the method with the smallest error among those that complete within 5 points of
/// the mark (see MarkOnInput), of those that are ranked_together(). Head: input, sensor, method, aligned, ATE, tracked,
/// ms per frame.
TextRows summary_rows(const Comparison& comparison);
/// Head: first, second, ratio, pairs, p, runs without a path, tracked %, remark.
TextRows difference_rows(const std::vector<PairedDifference>& differences);
/// Head: input, method, disturbance, holds, fails at, how.
TextRows strength_rows(const Comparison& comparison);
/// Head: method, then each stage in ms per frame; medians. Of one input; only a head without any.
TextRows stage_rows(const Comparison& comparison, const std::string& input);
/// Head: method, then each named length: its error in mm. Only a head without any.
TextRows length_rows(const Comparison& comparison, const std::string& input);

std::string report_as_markdown(const Report& report);
/// booktabs; one table per input, and the differences.
std::string report_as_latex(const Report& report);
/// One line per value: input, method, seed, repeat, figure, value, command.
std::string report_as_csv(const Comparison& comparison);

}  // namespace rastro::cli
