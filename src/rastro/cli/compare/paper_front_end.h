// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/paper_table.h"

namespace rastro::cli {

/// Tracks every input without depth by each tracker; `recordings`: of the inputs. An input that cannot be tracked is
/// left out.
std::vector<FrontEndFigures> front_end_figures(const std::vector<CompareInput>& inputs,
                                               const std::vector<std::string>& recordings);

/// Table I of the front-end paper: its mean row beside those of Comparison::front_end.
std::vector<PaperTable> paper_front_end_tables(const Comparison& comparison);

}  // namespace rastro::cli
