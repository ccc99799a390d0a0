// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/evaluate/score_limit.h"
#include "rastro/evaluate/track_scores.h"

namespace rastro {

/// For programs: one JSON object; null where there was nothing to count. With `per_frame` also the array "frames".
std::string scores_as_json(const TrackScores& scores, bool per_frame);
/// For people.
std::string scores_as_text(const TrackScores& scores, bool per_frame);
/// One row a frame, with a header line.
std::string scores_as_csv(const TrackScores& scores);

/// A figure that can be asked for by its name in the JSON, such as "recall" or "wrong"; nullopt when there was nothing
/// to count. Throws Error for a name that is none, naming the nearest.
std::optional<double> score_named(const TrackScores& scores, const std::string& name);

/// Throws Error when the text is no limit or names no score.
ScoreLimit parse_limit(const std::string& text);
/// A score with nothing to count keeps no limit.
bool keeps_limit(const TrackScores& scores, const ScoreLimit& limit);

}  // namespace rastro
