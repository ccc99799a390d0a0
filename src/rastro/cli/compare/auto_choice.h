// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/report_text.h"

namespace rastro::cli {

/// `slam --method auto` on one input beside the best of the SLAM methods that were run by name there.
struct AutoOnInput {
  std::string input, best;
  double error_m = 0.0, best_error_m = 0.0;                        ///< ATE, medians.
  double completion_percent = 0.0, best_completion_percent = 0.0;  ///< Medians; the latter of the mark (MarkOnInput).
  double ratio() const { return error_m / best_error_m; }
};

/// Of every input with both. Only methods that are aligned as `auto` is are compared: a path that claims meters is not
/// ranked with one whose scale was fitted.
std::vector<AutoOnInput> auto_on_inputs(const Comparison& comparison);

/// Head: input, best method, its ATE, that of auto, ratio, tracked of both. With the median and the worst ratio below;
/// only a head without any input.
TextRows auto_rows(const std::vector<AutoOnInput>& inputs);

}  // namespace rastro::cli
