// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rastro/cli/compare/report_tables.h"

namespace rastro::cli {

/// Charts of one input: error over time, trajectories from above; of each method the run with the median error.
std::string charts_of(const Report& report, std::size_t input);

/// How error and completion change with the strength of each disturbance, per input.
std::string strength_charts_of(const Comparison& comparison);

/// Of one method on an input the run with the median error.
struct PicturedRun {
  std::string column;
  const FinishedRun* run;
};
std::vector<PicturedRun> pictured_runs(const Report& report, std::size_t input);

/// Of each of these runs its map, with links to its page (see write_map_pages) and folder.
std::string maps_of(const Report& report, std::size_t input, const std::filesystem::path& folder);

/// Where tracking was first lost, with the image of that frame and the reason that the run gives; and runs that failed.
std::string failures_of(const Comparison& comparison);

}  // namespace rastro::cli
