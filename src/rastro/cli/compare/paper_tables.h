// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/paired_differences.h"
#include "rastro/cli/compare/paper_table.h"

namespace rastro::cli {

/// The tables of the three papers beside ours, as far as the inputs allow: lengths and behavior of the comparison paper
/// in rooms, Table I of the front-end paper, figures 9 to 14 of the positioning paper.
std::vector<PaperTable> paper_tables(const Comparison& comparison, const std::vector<ColumnTrace>& traces);

/// What 'rastro compare --paper' compares without being told otherwise: inputs, methods on an input, disturbances.
std::vector<std::string> paper_inputs();
std::vector<std::string> paper_methods(const InputFacts& facts);
std::vector<std::string> paper_disturbances();

}  // namespace rastro::cli
