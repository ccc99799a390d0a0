// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rastro/cli/benchmark/benchmark_plan.h"
#include "rastro/cli/benchmark/benchmark_result.h"

namespace rastro::cli {

/// Judges the files of a run: stats.csv, trajectory.txt and result.json. `map_folder`: the run that made the map, for
/// localization. Paths of the judgment are resolved. Error where a file that a run writes is missing or broken, or the
/// ground truth cannot be read.
RunScores score_run(const std::filesystem::path& folder, const BenchmarkJudgment& judgment,
                    const std::filesystem::path& map_folder);

}  // namespace rastro::cli
