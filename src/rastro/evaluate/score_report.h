// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/evaluate/score_limit.h"
#include "rastro/evaluate/track_scores.h"

namespace rastro {

/// As JSON: one object; null for values with nothing to count. With `per_frame` also the array "frames".
std::string scores_as_json(const TrackScores& scores, bool per_frame);
/// As text.
std::string scores_as_text(const TrackScores& scores, bool per_frame);
/// As CSV: one row per frame, with a header line.
std::string scores_as_csv(const TrackScores& scores);

/// A figure by its name in the JSON, such as "recall" or "wrong"; nullopt with nothing to count. Throws Error for an
/// unknown name, naming the nearest.
std::optional<double> score_named(const TrackScores& scores, const std::string& name);

/// Throws Error if the text is not a limit or names no score.
ScoreLimit parse_limit(const std::string& text);
/// False for a score with nothing to count.
bool keeps_limit(const TrackScores& scores, const ScoreLimit& limit);

}  // namespace rastro
