// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/report_text.h"

namespace rastro::cli {

constexpr const char* auto_column = "auto";

/// `slam --method auto` on one input beside the best of the SLAM methods that were run by name there.
struct AutoOnInput {
  std::string input, best;
  std::optional<double> error_m;  ///< ATE, median; none where half of the runs of auto gave no path.
  double best_error_m = 0.0;
  double completion_percent = 0.0, best_completion_percent = 0.0;  ///< Medians; the latter of the mark (MarkOnInput).
  /// None without an error, and where auto tracks fewer frames by more than completion_points.
  std::optional<double> ratio() const;
};

/// Of every input where auto was run and another method has an error. Only methods that are aligned as `auto` is are
/// compared: a path that claims meters is not ranked with one whose scale was fitted.
std::vector<AutoOnInput> auto_on_inputs(const Comparison& comparison);

/// Head: input, best method, its ATE, that of auto, ratio, tracked of both. With the median and the worst ratio below,
/// for which an input without one is worse than any; only a head without any input.
TextRows auto_rows(const std::vector<AutoOnInput>& inputs);

}  // namespace rastro::cli
