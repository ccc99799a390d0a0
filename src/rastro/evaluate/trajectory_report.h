// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/evaluate/score_limit.h"
#include "rastro/evaluate/trajectory_scores.h"

namespace rastro {

/// As text: all figures of one estimate.
std::string trajectory_scores_as_text(const TrajectoryScores& scores);
/// As a table: one line per estimate. If their coverage differs by more than 1 % it says that the errors are no
/// ranking.
std::string trajectory_scores_as_table(const std::vector<TrajectoryScores>& all);

/// As JSON: one object, null for missing values; an array of them for several estimates.
std::string trajectory_scores_as_json(const std::vector<TrajectoryScores>& all);

/// A figure by its name in the JSON, such as "ate_rmse"; nullopt for a missing value. Throws Error for an unknown name,
/// naming the nearest.
std::optional<double> trajectory_score_named(const TrajectoryScores& scores, const std::string& name);
/// Throws Error if the text is not a limit or names no figure.
ScoreLimit parse_trajectory_limit(const std::string& text);

}  // namespace rastro
