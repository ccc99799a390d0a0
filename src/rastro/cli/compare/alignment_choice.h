// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"

namespace rastro::cli {

/// Those of the columns whose errors on the input can be ranked: all aligned alike, as an error after fitting the scale
/// (Sim3) is smaller than the same one in meters. By SE3 where any is, else within the plane, and up to scale only
/// where all are. Columns without an error stay: they gave no path, however it would be aligned.
std::vector<std::string> ranked_together(const Comparison& comparison, std::size_t input,
                                         const std::vector<std::string>& columns);

/// Whether every error of the column is after fitting the scale.
bool is_up_to_scale(const Comparison& comparison, std::size_t input, const std::string& column);

}  // namespace rastro::cli
