// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/cli/benchmark/benchmark_plan.h"
#include "rastro/cli/benchmark/benchmark_result.h"

namespace rastro::cli {

/// Judges the files of a run: stats.csv, trajectory.txt and result.json. `map_folder`: the run that made the map, for
/// localization. Paths of the judgment are resolved. Error where a file that a run writes is missing or broken, or the
/// ground truth cannot be read.
RunScores score_run(const std::filesystem::path& folder, const BenchmarkJudgment& judgment,
                    const std::filesystem::path& map_folder);

/// The ground truth itself, or the file of poses that lies in the folder of a laser log by 'rastro simulate'.
std::string poses_beside(const std::string& ground_truth);

}  // namespace rastro::cli
