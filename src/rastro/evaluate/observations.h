// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "rastro/evaluate/track_scores.h"

namespace rastro {

/// One feature of a table, with the index of its frame in the table.
struct Observation {
  std::int64_t frame = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  TrackState state = TrackState::fresh;
};

/// All observations of one id in the order of frames.
using Track = std::vector<Observation>;

/// The tracks of the frames [first, end) of a table. Only observations inside the range are kept, so nothing outside it
/// can be counted by mistake; `before` of a track is the last observation before the range.
struct TrackIndex {
  std::int64_t first = 0, end = 0;
  std::map<std::int64_t, Track> tracks;        ///< By id, in ascending order.
  std::map<std::int64_t, Observation> before;  ///< By id: last observation before the range.
  int duplicate_ids = 0;
};

/// Throws Error for an empty range or options out of range.
TrackIndex index_tracks(const TrackTable& table, const TrackScoreOptions& options);

/// True if the observation at `position` of the track was re-identified rather than tracked.
bool is_reidentification(const Track& track, std::size_t position);

/// True if the id is missing in the frame after the observation at `position`.
bool ends_at(const Track& track, std::size_t position);

/// Whether nothing can be detected there because the image's edge is too close; false if the image's size is unknown.
bool near_image_edge(const Eigen::Vector2d& pixel, const TrackScoreOptions& options);

/// Rows of the scored frames with the tracker's own counts, to which the scores are added.
std::vector<FrameScores> frame_rows(const TrackTable& table, const TrackIndex& index);

/// Why a feature that reappeared at `visible_at` (frame and pixel, in order of frames) was not re-identified.
/// `return_frame`: the frame in which the id was wrongly re-identified, if any.
void book_miss(const TrackTable& table, const std::vector<std::pair<std::int64_t, Eigen::Vector2d>>& visible_at,
               std::optional<std::int64_t> return_frame, const TrackScoreOptions& options, MissReasons& reasons);

/// Lengths, totals of the rows, recall and precision.
void finish_scores(const TrackIndex& index, TrackScores& scores);

}  // namespace rastro
