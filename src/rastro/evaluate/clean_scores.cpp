// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/clean_scores.h"

#include <algorithm>

#include "rastro/evaluate/clean_segments.h"
#include "rastro/evaluate/observations.h"

namespace rastro {
namespace {

class CleanScorer {
 public:
  CleanScorer(const TrackTable& occluded, const TrackTable& clean, const OccluderCover* cover,
              const TrackScoreOptions& options)
      : table_(occluded),
        cover_(cover),
        options_(options),
        index_(index_tracks(occluded, options)),
        clean_(occluded, clean) {
    scores_.ground_truth = "clean run";
    scores_.frames = frame_rows(occluded, index_);
  }

  TrackScores score() {
    for (const auto& [id, track] : index_.tracks) {
      for (std::size_t i = 0; i < track.size(); ++i) {
        if (is_reidentification(track, i)) book_reidentification(track, i);
        if (i > 0) book_switch(track, i);
        if (ends_at(track, i) && track[i].frame + 1 < index_.end) book_loss(track, i);
      }
    }
    finish_scores(index_, scores_);
    return std::move(scores_);
  }

 private:
  enum class Verdict { correct, unscored, hidden, other_position, on_occluder };

  FrameScores& row(std::int64_t frame) { return scores_.frames[static_cast<std::size_t>(frame - index_.first)]; }
  bool covered(std::int64_t frame, const Eigen::Vector2d& pixel) const {
    return cover_ && cover_->covered(frame, pixel, 0.0);
  }
  bool near_edge(const Eigen::Vector2d& pixel) const { return near_image_edge(pixel, options_); }

  /// The segment that is the counterpart of the feature last observed as track[i]; null if there is none.
  const CleanSegment* counterpart(const Track& track, std::size_t i) const {
    const std::int64_t oldest = track[i].frame - options_.window;
    for (std::size_t k = i + 1; k-- > 0;) {
      if (track[k].frame < oldest) break;
      if (k < i && track[k + 1].frame != track[k].frame + 1) break;
      if (cover_ && cover_->covered(track[k].frame, track[k].pixel, options_.clearance_px)) {
        // A re-identification here gives no evidence of the id's earlier position.
        if (is_reidentification(track, k)) break;
        continue;
      }
      return clean_.nearest(track[k].frame, track[k].pixel, options_.same_feature_px);
    }
    return nullptr;
  }

  /// True if the id has been observed only on the occluder, up to track[i]: it belongs to the occluder's own texture.
  bool only_on_occluder(const Track& track, std::size_t i) const {
    for (std::size_t k = i + 1; k-- > 0;)
      if (!covered(track[k].frame, track[k].pixel)) return false;
    return true;
  }

  Verdict judge_reidentification(const Track& track, std::size_t i) const {
    if (i == 0) return Verdict::unscored;
    const Observation& observation = track[i];
    const bool clear = cover_ && !cover_->covered(observation.frame, observation.pixel, options_.tolerance_px);
    if (clear && only_on_occluder(track, i - 1)) return Verdict::other_position;
    return judge(counterpart(track, i - 1), observation);
  }

  Verdict judge(const CleanSegment* ground_truth, const Observation& observation) const {
    const auto position = ground_truth ? ground_truth->at(observation.frame) : std::nullopt;
    if (!position) return Verdict::unscored;
    if (covered(observation.frame, *position)) return Verdict::hidden;
    if ((*position - observation.pixel).norm() > options_.tolerance_px) return Verdict::other_position;
    return covered(observation.frame, observation.pixel) ? Verdict::on_occluder : Verdict::correct;
  }

  void book_reidentification(const Track& track, std::size_t i) {
    FrameScores& frame = row(track[i].frame);
    ++frame.reidentified;
    const Verdict verdict = judge_reidentification(track, i);
    if (verdict == Verdict::correct || verdict == Verdict::unscored) {
      ++(verdict == Verdict::correct ? frame.correct : frame.unscored);
      const bool on_occluder = i > 0 && verdict == Verdict::unscored && only_on_occluder(track, i - 1);
      scores_.unscored_on_occluder += on_occluder;
      return;
    }
    ++frame.wrong;
    scores_.wrongs.anchor_occluded += verdict == Verdict::hidden;
    scores_.wrongs.other_position += verdict == Verdict::other_position;
    scores_.wrongs.on_occluder += verdict == Verdict::on_occluder;
  }

  void book_switch(const Track& track, std::size_t i) {
    const CleanSegment* ground_truth = counterpart(track, i - 1);
    const auto position = ground_truth ? ground_truth->at(track[i].frame) : std::nullopt;
    if (position && (*position - track[i].pixel).norm() > options_.tolerance_px) ++scores_.id_switches;
  }

  void book_loss(const Track& track, std::size_t i);

  const TrackTable& table_;
  const OccluderCover* cover_;
  const TrackScoreOptions options_;
  const TrackIndex index_;
  const CleanSegments clean_;
  TrackScores scores_;
};

void CleanScorer::book_loss(const Track& track, std::size_t i) {
  const std::int64_t seen = track[i].frame;
  FrameScores& frame = row(seen + 1);
  const CleanSegment* ground_truth = counterpart(track, i);
  if (!ground_truth) {
    ++frame.lost_unscored;
    return;
  }
  const std::int64_t window_end = std::min(seen + options_.window, index_.end - 1);
  const bool returns = i + 1 < track.size() && track[i + 1].frame <= window_end;
  const std::int64_t span_end = returns ? track[i + 1].frame : window_end;
  bool occluded_in_span = false, occluded_before = false;
  std::vector<std::pair<std::int64_t, Eigen::Vector2d>> visible_again;
  for (std::int64_t k = seen + 1; k <= std::min(window_end, ground_truth->last()); ++k) {
    const auto position = ground_truth->at(k);
    if (!position) continue;
    const bool hidden = cover_ ? covered(k, *position) : k == seen + 1;
    if (hidden) occluded_in_span = occluded_in_span || k <= span_end;
    occluded_before = occluded_before || hidden;
    if (occluded_before && !hidden && !near_edge(*position)) visible_again.emplace_back(k, *position);
  }
  const bool ends_at_edge = ground_truth->last() < window_end && near_edge(ground_truth->positions.back());
  const bool followed_on = ground_truth->last() >= window_end || ends_at_edge;
  if (!occluded_in_span) {
    if (ends_at_edge)
      ++frame.lost_outside;
    else
      ++(followed_on || ground_truth->last() > seen ? frame.lost_visible : frame.lost_unscored);
    return;
  }
  // Occluded, and the counterpart ends before it could reappear.
  if (visible_again.empty() && !followed_on) {
    ++frame.lost_unscored;
    return;
  }
  // The id was re-identified after the end of its counterpart: correctness unknown.
  const Verdict verdict = returns ? judge(ground_truth, track[i + 1]) : Verdict::unscored;
  if (returns && verdict == Verdict::unscored) {
    ++frame.lost_unscored;
    return;
  }
  ++frame.lost;
  if (visible_again.empty()) return;
  ++row(visible_again.front().first).reappeared;
  if (verdict == Verdict::correct)
    ++row(track[i + 1].frame).recalled;
  else
    book_miss(table_, visible_again, returns ? std::optional(span_end) : std::nullopt, options_, scores_.misses);
}

}  // namespace

TrackScores score_clean_tracks(const TrackTable& occluded, const TrackTable& clean, const OccluderCover* cover,
                               const TrackScoreOptions& options) {
  return CleanScorer(occluded, clean, cover, options).score();
}

}  // namespace rastro
