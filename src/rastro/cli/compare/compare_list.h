// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_list.h"
#include "rastro/cli/compare/compare_input.h"
#include "rastro/cli/compare/compare_plan.h"

namespace rastro::cli {

/// An entry of a benchmark list as a cell of the comparison.
struct ListedCell {
  std::size_t input = 0;
  MethodOffer method;
  std::string
      column;  ///< The method with its sensor and settings; two alike on one input have the names of their entries.
};

/// Inputs and columns of a list. Entries are of one input where they read the same: data or world, frames, flags of
/// 'rastro simulate', disturbances and map.
struct ListedCells {
  std::vector<CompareInput> inputs;
  std::vector<ListedCell> cells;  ///< In the order of the entries.
};

ListedCells cells_of(const BenchmarkList& list);

/// Gives each cell without a sensor the one that its method takes on its input, and its column that name. `inputs`:
/// those of the cells, with their facts.
void choose_sensors(const BenchmarkList& list, const std::vector<CompareInput>& inputs, ListedCells& cells);

/// Adds every entry: `repeats` as plan_methods(). The facts of the inputs are known.
void plan_list(const BenchmarkList& list, const ListedCells& cells, const std::vector<CompareInput>& inputs,
               int repeats, ComparePlan& plan);

}  // namespace rastro::cli
