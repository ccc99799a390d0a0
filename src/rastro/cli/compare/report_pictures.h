// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/cli/compare/report_tables.h"

namespace rastro::cli {

/// Charts of one input: error over time, trajectories from above; of each method the run with the median error.
std::string charts_of(const Report& report, std::size_t input);

/// How error and completion change with the strength of each disturbance, per input.
std::string strength_charts_of(const Comparison& comparison);

/// The map of each method on the input, with links to its run folder and the command that shows it.
std::string maps_of(const Report& report, std::size_t input, const std::filesystem::path& folder);

/// Where tracking was first lost, with the image of that frame and the reason that the run gives; and runs that failed.
std::string failures_of(const Comparison& comparison);

}  // namespace rastro::cli
