// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"

namespace rastro::cli {

/// Rows of cells; the first is the head.
using TextRows = std::vector<std::vector<std::string>>;

/// How the errors of a column are aligned, "SE3" or "Sim3", in the plane "yaw"; "-" where there are none.
std::string alignment_text(const Comparison& comparison, std::size_t input, const std::string& column);

/// The figures that any column of the input has a value of, in the order of compare_figures().
std::vector<const FigureKind*> figures_on(const ResultTable& table, const std::string& input);

/// One row per column of the table: method, runs, alignment, and each figure as median, with the worst behind it where
/// there are several values and these differ; `all_figures`: also those that are not in short tables.
TextRows rows_on(const Comparison& comparison, std::size_t input, bool all_figures);

/// Of which runs the values of the tables are: medians, failures, and times where other runs went on beside them.
std::string values_text(const Comparison& comparison);
/// The last of these; empty where each run had the machine for itself.
std::string load_text(const Comparison& comparison);

/// Columns side by side, the first to the left.
std::string aligned_text(const TextRows& rows);

/// The tables of all inputs, and what failed or was refused.
std::string comparison_as_text(const Comparison& comparison);

}  // namespace rastro::cli
