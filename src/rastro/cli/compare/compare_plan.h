// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/benchmark_plan.h"
#include "rastro/cli/compare/compare_input.h"
#include "rastro/cli/compare/method_offers.h"

namespace rastro::cli {

/// What a run of the plan is in the comparison.
struct CompareRun {
  std::size_t input = 0;    ///< Of the inputs.
  std::string column;       ///< As MethodOffer::name().
  int repeat = 1;           ///< From 1; the seed of RANSAC.
  bool again = false;       ///< The first repeat once more: are the bytes equal?
  std::string disturbance;  ///< NAME=VALUE; empty: none.
};

/// A comparison as a list of the benchmark, which plans, runs and resumes it. Entry k is what `runs[k]` says.
struct ComparePlan {
  BenchmarkList list;
  std::vector<CompareRun> runs;
};

/// Adds every method on the input: `repeats` times with seeds 1 to that where random numbers decide its result, and if
/// there is more than one the first again.
void plan_methods(const CompareInput& input, std::size_t index, const std::vector<MethodOffer>& methods, int repeats,
                  ComparePlan& plan);

/// Adds the planned first run of a method on input `index` once more, with a disturbance; of a world only the first
/// seed.
void plan_disturbed(std::size_t index, const std::string& method, const std::string& disturbance, ComparePlan& plan);

}  // namespace rastro::cli
