// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/alignment_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

namespace rastro::cli {
namespace {

constexpr const char* fits_scale = "sim3";

/// Of the errors of a column, "se3, sim3" where they differ; empty: it has none. "-": not aligned.
std::string aligned_by(const Comparison& comparison, std::size_t input, const std::string& column) {
  std::set<std::string> all;
  const auto add = [&](const std::string& alignment) { all.insert(alignment.empty() ? "-" : alignment); };
  for (const FinishedRun& run : comparison.runs)
    if (run.is_plain() && run.what.input == input && run.what.column == column && !run.failed() &&
        run.result.scores.ate_m)
      add(run.result.scores.alignment);
  for (const ImportedTrajectory& import : comparison.imported)
    if (import.input == input && import.column == column) add(import.alignment);
  return fmt::format("{}", fmt::join(all, ", "));
}

}  // namespace

std::vector<std::string> ranked_together(const Comparison& comparison, std::size_t input,
                                         const std::vector<std::string>& columns) {
  std::map<std::string, std::string> by_column;
  std::vector<std::string> order = {"se3", "yaw", "-", fits_scale};
  for (const std::string& column : columns) {
    by_column[column] = aligned_by(comparison, input, column);
    order.push_back(by_column[column]);
  }
  const auto chosen = std::find_if(order.begin(), order.end(), [&](const std::string& alignment) {
    return !alignment.empty() &&
           std::any_of(by_column.begin(), by_column.end(), [&](const auto& each) { return each.second == alignment; });
  });
  std::vector<std::string> together;
  for (const std::string& column : columns)
    if (by_column[column].empty() || by_column[column] == *chosen) together.push_back(column);
  return together;
}

bool is_up_to_scale(const Comparison& comparison, std::size_t input, const std::string& column) {
  return aligned_by(comparison, input, column) == fits_scale;
}

}  // namespace rastro::cli
