// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/paper_lengths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace rastro::cli {
namespace {

constexpr const char* note =
    "The paper's ORB- and LSD-SLAM saw with one camera, its maps were measured by hand; 'rastro measure' measures "
    "ours. "
    "Maps of one camera ('mono') are scaled by the longest known length, which is left out. The rooms are generated, "
    "with the paper's lengths.";

/// The first word: "orb" of "orb rgbd".
std::string method_of(const std::string& column) { return column.substr(0, column.find(' ')); }

std::string meters(double value) { return fmt::format("{:.3f}", value); }

std::vector<std::string> row_of(const PublishedLength& length, const PublishedLength::Measured& published,
                                const std::string& column, const std::vector<double>& errors) {
  std::vector<std::string> row = {fmt::format("{} ({} m)", length.name, length.true_m),
                                  column,
                                  fmt::format("{}", errors.size()),
                                  "-",
                                  "-",
                                  meters(published.mean_m),
                                  meters(published.max_error_m)};
  if (errors.empty()) return row;
  const auto count = static_cast<double>(errors.size());
  double largest = 0.0;
  for (const double error : errors) largest = std::max(largest, std::abs(error));
  row[3] = fmt::format("{:.4f}", length.true_m + std::accumulate(errors.begin(), errors.end(), 0.0) / count);
  row[4] = fmt::format("{:.4f}", largest);
  return row;
}

void add_rows(const Comparison& comparison, const std::string& input, const PublishedLength& length, TextRows& rows) {
  for (const PublishedLength::Measured& published : length.measured)
    for (const std::string& column : comparison.table.columns_on(input))
      if (method_of(column) == published.method)
        rows.push_back(
            row_of(length, published, column, comparison.table.values(input, column, "length/" + length.name + "_m")));
}

}  // namespace

const std::vector<PublishedLength>& published_lengths() {
  static const std::vector<PublishedLength> lengths = {
      {"bedroom",
       "blue box width",
       0.32,
       {{"rtabmap", 0.311, 0.01}, {"orb", 0.28, 0.25}, {"lsd", 0.29, 0.2}, {"rgbd", 0.3, 0.02}}},
      {"bedroom",
       "blue box height",
       0.25,
       {{"rtabmap", 0.26, 0.01}, {"orb", 0.21, 0.15}, {"lsd", 0.23, 0.2}, {"rgbd", 0.25, 0.03}}},
      {"bedroom",
       "bed length",
       2.0,
       {{"rtabmap", 2.1, 0.1}, {"orb", 1.05, 1.0}, {"lsd", 0.96, 1.2}, {"rgbd", 1.77, 0.2}}},
      {"study",
       "shelf height",
       0.16,
       {{"rtabmap", 0.15, 0.01}, {"orb", 0.1, 0.06}, {"lsd", 0.12, 0.09}, {"rgbd", 0.16, 0.02}}},
      {"study",
       "shelf width",
       0.75,
       {{"rtabmap", 0.75, 0.05}, {"orb", 0.45, 0.3}, {"lsd", 0.4, 0.35}, {"rgbd", 0.77, 0.05}}},
      {"study",
       "calendar height",
       0.42,
       {{"rtabmap", 0.39, 0.03}, {"orb", 0.3, 0.15}, {"lsd", 0.29, 0.2}, {"rgbd", 0.44, 0.03}}},
      {"study",
       "glass table width",
       0.85,
       {{"rtabmap", 0.95, 0.3}, {"orb", 0.46, 0.4}, {"lsd", 0.4, 0.45}, {"rgbd", 0.5, 0.36}}},
  };
  return lengths;
}

std::vector<PaperTable> paper_length_tables(const Comparison& comparison) {
  std::vector<PaperTable> tables;
  for (const CompareInput& input : comparison.inputs) {
    PaperTable table;
    table.title =
        fmt::format("The comparison paper's table {}: {}", input.input.world == "bedroom" ? 1 : 2, input.name);
    table.rows = {{"length", "method", "maps", "mean [m]", "max error [m]", "paper: mean", "paper: max error"}};
    for (const PublishedLength& length : published_lengths())
      if (length.world == input.input.world) add_rows(comparison, input.name, length, table.rows);
    if (table.rows.size() > 1) tables.push_back(std::move(table));
  }
  if (!tables.empty()) tables.back().note = note;
  return tables;
}

}  // namespace rastro::cli
