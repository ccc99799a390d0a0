// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/evaluate/score_limit.h"
#include "rastro/evaluate/trajectory_scores.h"

namespace rastro {

/// For people: every figure of one estimate.
std::string trajectory_scores_as_text(const TrajectoryScores& scores);
/// For people: a line for each estimate; where their coverage differs by more than 1 % it says that they are no rank.
std::string trajectory_scores_as_table(const std::vector<TrajectoryScores>& all);

/// For programs: one JSON object, null where there was nothing to measure; an array of them for several estimates.
std::string trajectory_scores_as_json(const std::vector<TrajectoryScores>& all);

/// A figure that can be asked for by its name in the JSON, such as "ate_rmse"; nullopt when there was nothing to
/// measure. Error for a name that is none, naming the nearest.
std::optional<double> trajectory_score_named(const TrajectoryScores& scores, const std::string& name);
/// Error when the text is no limit or names no figure.
ScoreLimit parse_trajectory_limit(const std::string& text);

}  // namespace rastro
