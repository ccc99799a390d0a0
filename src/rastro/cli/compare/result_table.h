// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace rastro::cli {

/// One value of a figure and how to get it.
struct Sample {
  double value = 0.0;
  std::uint64_t seed = 0;  ///< Of the world; 0 for a recording.
  int repeat = 1;
  std::string command;  ///< Prints or writes this value.
};

/// A figure that is compared.
struct FigureKind {
  std::string name;   ///< With its unit: "ate_m". As in results and CSV.
  std::string title;  ///< Head of a column: "ATE [m]".
  int digits = 3;     ///< Behind the point.
  bool more_is_better = false;
  std::string explanation;  ///< One sentence.
  bool in_text = true;      ///< Also in the short tables.
};

/// The model of every report: a table of cells, input x column x figure -> values over seeds and repeats, each with its
/// command. It knows nothing of methods or recordings: a column may be a method with its sensor, a preset, a
/// trajectory of another program or the figures of a publication; an input may be a recording, a world or a scene of a
/// paper; a figure any number. Names are as shown; inputs and columns keep the order in which they came.
class ResultTable {
 public:
  void add(const std::string& input, const std::string& column, const std::string& figure, Sample sample);
  /// An input or column without any sample yet, so that a table shows it.
  void add_input(const std::string& input);
  void add_column(const std::string& column);

  const std::vector<std::string>& inputs() const { return inputs_; }
  const std::vector<std::string>& columns() const { return columns_; }
  /// Empty where there are none.
  const std::vector<Sample>& samples(const std::string& input, const std::string& column,
                                     const std::string& figure) const;
  std::vector<double> values(const std::string& input, const std::string& column, const std::string& figure) const;
  std::optional<double> median(const std::string& input, const std::string& column, const std::string& figure) const;
  /// Of ate_m, where a run without one counts as worse than any with one; none where these are half of the runs. A run
  /// is what has completion_percent.
  std::optional<double> median_error(const std::string& input, const std::string& column) const;
  /// Runs of the column on the input, and those of them without ate_m, where any column has one.
  int runs(const std::string& input, const std::string& column) const;
  int runs_without_error(const std::string& input, const std::string& column) const;
  /// The largest by its size, or of a figure of which more is better the smallest.
  std::optional<double> worst(const std::string& input, const std::string& column, const FigureKind& figure) const;
  /// Columns with any sample on the input, in their order.
  std::vector<std::string> columns_on(const std::string& input) const;

 private:
  std::vector<std::string> inputs_, columns_;
  std::map<std::tuple<std::string, std::string, std::string>, std::vector<Sample>> cells_;
};

/// What methods are measured by on one input: a method with more than twice the smallest error, or one that tracks less
/// than half of the frames (unless all do), sets no mark for the others, however much it claims to track.
struct MarkOnInput {
  std::optional<double> error_m;    ///< The smallest; none where no column has one.
  double completion_percent = 0.0;  ///< Of the most complete one.
};
constexpr double most_error_factor = 2.0, completion_points = 5.0;
MarkOnInput mark_on(const ResultTable& table, const std::string& input, const std::vector<std::string>& columns);

/// The column with the smallest error among those within `completion_points` of the mark; empty: none has an error.
std::string best_on(const ResultTable& table, const std::string& input, std::vector<std::string> columns);

/// The figures of `rastro compare` in the order of its tables.
const std::vector<FigureKind>& compare_figures();
/// One of them.
const FigureKind& compare_figure(const std::string& name);

/// "0.0123"; "-" without a value.
std::string figure_text(const FigureKind& figure, const std::optional<double>& value);

}  // namespace rastro::cli
