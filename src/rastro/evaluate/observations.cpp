// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/observations.h"

#include <algorithm>

#include "rastro/base/error.h"

namespace rastro {
namespace {

void check_options(const TrackScoreOptions& options) {
  const auto refuse = [](const char* what, const char* where) {
    throw Error(what, where, "see `rastro evaluate tracks --help` for the ranges");
  };
  if (options.window < 1) refuse("the window must be at least 1 frame", "--window");
  if (!(options.tolerance_px > 0.0)) refuse("the tolerance must be above 0 px", "--tolerance");
  if (!(options.border_px >= 0.0)) refuse("the border must not be negative", "--border");
  if (!(options.min_distance_px >= 0.0))
    refuse("the minimum distance of corners must not be negative", "--min-distance");
  if (options.first_frame < 0) refuse("the first frame must not be negative", "--frames");
}

bool someone_within(const TrackFrame& frame, const Eigen::Vector2d& pixel, double distance, bool only_detected_here) {
  return std::any_of(frame.features.begin(), frame.features.end(), [&](const TrackedFeature& feature) {
    const bool detected_here = feature.state != TrackState::tracked;
    return detected_here == only_detected_here && (feature.pixel.cast<double>() - pixel).norm() <= distance;
  });
}

bool detects_anything(const TrackFrame& frame) {
  return std::any_of(frame.features.begin(), frame.features.end(),
                     [](const TrackedFeature& feature) { return feature.state != TrackState::tracked; });
}

std::optional<double> ratio(int part, int whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / whole;
}

void count_lengths(const TrackIndex& index, TrackScores& scores) {
  const std::vector<int>& bins = length_bins();
  scores.length_histogram.assign(bins.size(), 0);
  std::vector<std::size_t> lengths;
  std::size_t sum = 0;
  for (const auto& [id, track] : index.tracks) {
    lengths.push_back(track.size());
    sum += track.size();
    const auto above = std::upper_bound(bins.begin(), bins.end(), static_cast<int>(track.size()));
    ++scores.length_histogram[static_cast<std::size_t>(above - bins.begin()) - 1];
  }
  scores.ids = static_cast<std::int64_t>(lengths.size());
  if (lengths.empty()) return;
  std::sort(lengths.begin(), lengths.end());
  const std::size_t half = lengths.size() / 2;
  const double upper = static_cast<double>(lengths[half]);
  const double lower = static_cast<double>(lengths[(lengths.size() - 1) / 2]);
  scores.mean_track_length = static_cast<double>(sum) / static_cast<double>(lengths.size());
  scores.median_track_length = (lower + upper) / 2.0;
}

}  // namespace

const std::vector<int>& length_bins() {
  static const std::vector<int> bins = {1, 2, 3, 6, 11, 21, 51, 101};
  return bins;
}

TrackIndex index_tracks(const TrackTable& table, const TrackScoreOptions& options) {
  check_options(options);
  TrackIndex index;
  index.first = options.first_frame;
  index.end = std::min(options.end_frame, static_cast<std::int64_t>(table.frames.size()));
  if (index.first >= index.end)
    throw Error("there is no frame to score (the run has " + std::to_string(table.frames.size()) + ")", "--frames",
                "give frames of the run as A:B, without B");
  for (std::int64_t k = 0; k < index.end; ++k) {
    for (const TrackedFeature& feature : table.frames[static_cast<std::size_t>(k)].features) {
      const Observation observation{k, feature.pixel.cast<double>(), feature.state};
      if (k < index.first) {
        index.before[feature.id] = observation;
        continue;
      }
      Track& track = index.tracks[feature.id];
      if (!track.empty() && track.back().frame == k)
        ++index.duplicate_ids;
      else
        track.push_back(observation);
    }
  }
  return index;
}

bool is_reidentification(const Track& track, std::size_t position) {
  if (track[position].state == TrackState::reidentified) return true;
  return position > 0 && track[position].frame > track[position - 1].frame + 1;
}

bool ends_at(const Track& track, std::size_t position) {
  return position + 1 == track.size() || track[position + 1].frame > track[position].frame + 1;
}

bool near_image_edge(const Eigen::Vector2d& pixel, const TrackScoreOptions& options) {
  if (options.image_width <= 0 || options.image_height <= 0) return false;
  const double border = options.border_px;
  return pixel.x() < border || pixel.y() < border || pixel.x() > options.image_width - 1 - border ||
         pixel.y() > options.image_height - 1 - border;
}

std::vector<FrameScores> frame_rows(const TrackTable& table, const TrackIndex& index) {
  std::vector<FrameScores> rows;
  for (std::int64_t k = index.first; k < index.end; ++k) {
    const TrackFrame& frame = table.frames[static_cast<std::size_t>(k)];
    FrameScores row;
    row.index = frame.index;
    row.features = static_cast<int>(frame.features.size());
    for (const TrackedFeature& feature : frame.features) {
      row.tracked += feature.state == TrackState::tracked;
      row.fresh += feature.state == TrackState::fresh;
    }
    rows.push_back(row);
  }
  return rows;
}

void book_miss(const TrackTable& table, const std::vector<std::pair<std::int64_t, Eigen::Vector2d>>& visible_at,
               std::optional<std::int64_t> return_frame, const TrackScoreOptions& options, MissReasons& reasons) {
  if (return_frame) {
    ++reasons.wrong_position;
    return;
  }
  bool detected = false, always_blocked = true, anything_detected = false;
  for (const auto& [k, pixel] : visible_at) {
    const TrackFrame& frame = table.frames[static_cast<std::size_t>(k)];
    detected = detected || someone_within(frame, pixel, options.tolerance_px, true);
    always_blocked = always_blocked && someone_within(frame, pixel, options.min_distance_px, false);
    anything_detected = anything_detected || detects_anything(frame);
  }
  if (detected)
    ++reasons.not_reidentified;
  else if (always_blocked)
    ++reasons.blocked;
  else if (!anything_detected)
    ++reasons.budget_full;
  else
    ++reasons.never_detected;
}

TrackCounts& TrackCounts::operator+=(const TrackCounts& other) {
  reidentified += other.reidentified;
  correct += other.correct;
  wrong += other.wrong;
  unscored += other.unscored;
  lost += other.lost;
  lost_outside += other.lost_outside;
  lost_visible += other.lost_visible;
  lost_unscored += other.lost_unscored;
  reappeared += other.reappeared;
  recalled += other.recalled;
  return *this;
}

void finish_scores(const TrackIndex& index, TrackScores& scores) {
  for (const FrameScores& row : scores.frames) scores += row;
  scores.frame_count = static_cast<int>(scores.frames.size());
  scores.duplicate_ids = index.duplicate_ids;
  scores.recall = ratio(scores.recalled, scores.reappeared);
  scores.precision = ratio(scores.correct, scores.correct + scores.wrong);
  count_lengths(index, scores);
}

}  // namespace rastro
