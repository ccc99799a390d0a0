// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/paper_behavior.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace rastro::cli {
namespace {

/// What the paper says of a method, in short.
struct Words {
  const char* method;
  const char* speed;
  const char* abrupt;
};
constexpr Words published[] = {
    {"rtabmap", "fast, no delay", "back in little more than 1 s"},
    {"orb", "fast where moved smoothly", "mostly back, a little slower; hard to relocalize"},
    {"lsd", "very slow, freezes and jumps", "lost often without any, mostly not back"},
    {"rgbd", "fast, no delay", "back in little more than 1 s"},
};

const StrengthCurve* curve_of(const Comparison& comparison, std::size_t input, const std::string& column,
                              const std::string& disturbance) {
  const auto found =
      std::find_if(comparison.strengths.begin(), comparison.strengths.end(), [&](const StrengthCurve& curve) {
        return curve.input == input && curve.column == column && curve.disturbance == disturbance;
      });
  return found == comparison.strengths.end() ? nullptr : &*found;
}

/// Of the longest gap: "32 frames: 0.00 s"; where it is not back "32 frames: not back".
std::string recovery_text(const Comparison& comparison, std::size_t input, const std::string& column,
                          const std::string& disturbance) {
  const StrengthCurve* curve = curve_of(comparison, input, column, disturbance);
  if (curve == nullptr || curve->steps.empty()) return "-";
  const StrengthStep& last = curve->steps.back();
  return fmt::format("{:g} frames: {}", last.strength,
                     last.recovery_s ? fmt::format("{:.2f} s", *last.recovery_s) : std::string("not back"));
}

std::vector<std::string> row_of(const Comparison& comparison, std::size_t input, const std::string& column,
                                const Words& words) {
  const auto cell = [&](const char* figure) {
    return figure_text(compare_figure(figure), comparison.table.median(comparison.inputs[input].name, column, figure));
  };
  return {column,
          cell("frames_per_second"),
          words.speed,
          cell("longest_loss_s"),
          recovery_text(comparison, input, column, "abrupt"),
          recovery_text(comparison, input, column, "covered"),
          words.abrupt};
}

}  // namespace

std::vector<PaperTable> paper_behavior_tables(const Comparison& comparison) {
  std::vector<PaperTable> tables;
  for (std::size_t input = 0; input < comparison.inputs.size(); ++input) {
    const CompareInput& of = comparison.inputs[input];
    if (!of.facts.has_depth) continue;
    PaperTable table;
    table.title = fmt::format("The comparison paper's section 8.3, speed, abrupt motion and loss: {}", of.name);
    table.rows = {{"method", "frames/s", "paper: speed", "longest loss [s]", "frames missing, then back after",
                   "covered, then back after", "paper: abrupt motion"}};
    for (const Words& words : published)
      for (const std::string& column : comparison.table.columns_on(of.name))
        if (column.substr(0, column.find(' ')) == words.method)
          table.rows.push_back(row_of(comparison, input, column, words));
    if (table.rows.size() > 1) tables.push_back(std::move(table));
  }
  if (!tables.empty())
    tables.back().note =
        "The paper gives no numbers for speed and recovery. Of the missing or covered frames the longest that was "
        "tried: "
        "the next is tried while the method neither loses track nor doubles its error.";
  if (const std::string load = load_text(comparison); !tables.empty() && !load.empty())
    tables.back().note += " " + load;
  return tables;
}

}  // namespace rastro::cli
