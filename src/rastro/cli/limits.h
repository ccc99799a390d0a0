// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "rastro/evaluate/score_limit.h"

namespace rastro::cli {

/// The values of a result by name.
using NamedNumbers = std::vector<std::pair<std::string, double>>;

/// The limits given with --require; Error for text that is not a limit and for names that are not among `known`.
std::vector<ScoreLimit> parse_limits(const std::vector<std::string>& texts, const NamedNumbers& known,
                                     const std::string& example);

/// Says on standard error which limits are missed. `limit_missed` if any is, else `done`.
int report_missed(const std::vector<ScoreLimit>& limits, const NamedNumbers& numbers);

/// One JSON object; whole numbers without a point, others with six digits.
std::string as_json(const NamedNumbers& numbers);

}  // namespace rastro::cli
