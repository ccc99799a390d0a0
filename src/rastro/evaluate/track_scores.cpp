// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/track_scores.h"

#include <algorithm>
#include <map>

#include "rastro/base/error.h"
#include "rastro/evaluate/observations.h"

namespace rastro {
namespace {

enum class Verdict { correct, unscored, unknown_id, anchor_outside, anchor_occluded, other_position, on_occluder };

/// The scoring of one run; a class only to avoid passing table, ground truth and options around.
class SurfaceScorer {
 public:
  SurfaceScorer(const TrackTable& table, const SurfaceGroundTruth& ground_truth, const TrackScoreOptions& options)
      : table_(table), ground_truth_(ground_truth), options_(options), index_(index_tracks(table, options)) {
    if (index_.end > ground_truth.frame_count())
      throw Error("the run has frame " + std::to_string(index_.end - 1) + " but the ground truth has only " +
                      std::to_string(ground_truth.frame_count()) + " frames",
                  "evaluate tracks", "give the data folder that the run was made on");
    scores_.ground_truth = "surfaces";
    scores_.frames = frame_rows(table, index_);
  }

  /// By frame throughout: ground truth read from files keeps only a window of frames in memory.
  TrackScores score() {
    find_points();
    for (const Seen& seen : in_order_) {
      if (is_reidentification(*seen.track, seen.position)) book_reidentification(seen);
      book_switch(seen);
      collect_drift(seen);
    }
    for (const Seen& seen : in_order_) {
      if (ends_at(*seen.track, seen.position) && seen.observation().frame + 1 < index_.end) book_loss(seen);
    }
    finish_drift();
    finish_scores(index_, scores_);
    return std::move(scores_);
  }

 private:
  struct Loss;
  using Point = std::optional<SurfacePoint>;

  /// One observation, and the previous one of its id with its surface point.
  struct Seen {
    const Track* track = nullptr;
    std::size_t position = 0;
    const Observation* previous = nullptr;  ///< Null for the first one of an id.
    Point* points = nullptr;                ///< Of the whole track.
    const Point* previous_point = nullptr;  ///< If there is a previous observation.

    const Observation& observation() const { return (*track)[position]; }
    Point& point() const { return points[position]; }
  };

  /// Orders the observations by frame, then id, and gets the surface point of each.
  void find_points() {
    for (const auto& [id, track] : index_.tracks) {
      std::vector<Point>& points = points_[id];
      points.resize(track.size());
      const auto before = index_.before.find(id);
      const bool goes_back = before != index_.before.end();
      if (goes_back) points_before_[id] = ground_truth_.surface_at(before->second.frame, before->second.pixel);
      in_order_.push_back(
          {&track, 0, goes_back ? &before->second : nullptr, points.data(), goes_back ? &points_before_[id] : nullptr});
      for (std::size_t i = 1; i < track.size(); ++i)
        in_order_.push_back({&track, i, &track[i - 1], points.data(), &points[i - 1]});
    }
    std::stable_sort(in_order_.begin(), in_order_.end(), [](const Seen& left, const Seen& right) {
      return left.observation().frame < right.observation().frame;
    });
    for (const Seen& seen : in_order_)
      seen.point() = ground_truth_.surface_at(seen.observation().frame, seen.observation().pixel);
  }

  FrameScores& row(std::int64_t frame) { return scores_.frames[static_cast<std::size_t>(frame - index_.first)]; }

  bool near_edge(const Eigen::Vector2d& pixel) const { return near_image_edge(pixel, options_); }

  bool same_point(const SurfacePoint& anchor, const Observation& anchor_seen, const SurfacePoint& point) const {
    if (anchor.surface == point.surface) return true;
    const ProjectedPoint back = ground_truth_.project(anchor_seen.frame, point);
    return back.visibility != Visibility::outside_image &&
           (back.pixel - anchor_seen.pixel).norm() <= options_.tolerance_px;
  }

  Verdict judge(const Observation& anchor_seen, const Point& anchor, const Observation& observation,
                const Point& point) const {
    if (!anchor || !point) return Verdict::unscored;
    const ProjectedPoint projection = ground_truth_.project(observation.frame, *anchor);
    if (projection.visibility == Visibility::outside_image) return Verdict::anchor_outside;
    if (projection.visibility == Visibility::occluded_by_surface) return Verdict::anchor_occluded;
    if ((projection.pixel - observation.pixel).norm() > options_.tolerance_px) return Verdict::other_position;
    return same_point(*anchor, anchor_seen, *point) ? Verdict::correct : Verdict::on_occluder;
  }

  void book_reidentification(const Seen& seen) {
    const Observation& observation = seen.observation();
    FrameScores& frame = row(observation.frame);
    ++frame.reidentified;
    const Verdict verdict =
        seen.previous ? judge(*seen.previous, *seen.previous_point, observation, seen.point()) : Verdict::unknown_id;
    if (verdict == Verdict::correct || verdict == Verdict::unscored) {
      ++(verdict == Verdict::correct ? frame.correct : frame.unscored);
      return;
    }
    ++frame.wrong;
    WrongReasons& wrongs = scores_.wrongs;
    wrongs.unknown_id += verdict == Verdict::unknown_id;
    wrongs.anchor_outside += verdict == Verdict::anchor_outside;
    wrongs.anchor_occluded += verdict == Verdict::anchor_occluded;
    wrongs.other_position += verdict == Verdict::other_position;
    wrongs.on_occluder += verdict == Verdict::on_occluder;
    for (std::size_t k = seen.position; k-- > 0;) {
      if (judge((*seen.track)[k], seen.points[k], observation, seen.point()) != Verdict::correct) continue;
      ++scores_.wrong_but_earlier_position;
      break;
    }
  }

  void book_switch(const Seen& seen) {
    if (!seen.previous || !*seen.previous_point) return;
    const ProjectedPoint projection = ground_truth_.project(seen.observation().frame, **seen.previous_point);
    if (projection.visibility == Visibility::outside_image ||
        (projection.pixel - seen.observation().pixel).norm() > options_.tolerance_px)
      ++scores_.id_switches;
  }

  void book_loss(const Seen& seen);

  void collect_drift(const Seen& seen) {
    if (seen.position == 0 || !seen.points[0]) return;
    const ProjectedPoint projection = ground_truth_.project(seen.observation().frame, *seen.points[0]);
    if (projection.visibility != Visibility::outside_image)
      drift_.push_back((projection.pixel - seen.observation().pixel).norm());
  }

  void finish_drift() {
    if (drift_.empty()) return;
    std::sort(drift_.begin(), drift_.end());
    scores_.drift_median_px = drift_[drift_.size() / 2];
    scores_.drift_p95_px = drift_[drift_.size() * 95 / 100];
    const auto beyond = drift_.end() - std::upper_bound(drift_.begin(), drift_.end(), options_.tolerance_px);
    scores_.drifted_share = static_cast<double>(beyond) / static_cast<double>(drift_.size());
  }

  const TrackTable& table_;
  const SurfaceGroundTruth& ground_truth_;
  const TrackScoreOptions options_;
  const TrackIndex index_;
  TrackScores scores_;
  std::map<std::int64_t, std::vector<Point>> points_;  ///< By id, as the tracks.
  std::map<std::int64_t, Point> points_before_;        ///< Of the observations before the range.
  std::vector<Seen> in_order_;
  std::vector<double> drift_;
};

/// The anchor's visibility in the window after its loss.
struct SurfaceScorer::Loss {
  bool occluded_in_span = false;
  std::vector<std::pair<std::int64_t, Eigen::Vector2d>>
      visible_again;  ///< Frames and positions, after it was occluded.
};

void SurfaceScorer::book_loss(const Seen& last_seen) {
  const Track& track = *last_seen.track;
  const std::size_t i = last_seen.position;
  const std::int64_t seen = track[i].frame;
  FrameScores& frame = row(seen + 1);
  const Point& anchor = last_seen.point();
  if (!anchor) {
    ++frame.lost_unscored;
    return;
  }
  const std::int64_t window_end = std::min(seen + options_.window, index_.end - 1);
  const bool returns = i + 1 < track.size() && track[i + 1].frame <= window_end;
  const std::int64_t span_end = returns ? track[i + 1].frame : window_end;
  const ProjectedPoint next = ground_truth_.project(seen + 1, *anchor);
  Loss loss;
  bool occluded_before = false;
  for (std::int64_t k = seen + 1; k <= window_end; ++k) {
    const ProjectedPoint projection = ground_truth_.project(k, *anchor);
    if (projection.visibility == Visibility::occluded_by_surface) {
      occluded_before = true;
      loss.occluded_in_span = loss.occluded_in_span || k <= span_end;
    } else if (occluded_before && projection.visibility == Visibility::visible && !near_edge(projection.pixel)) {
      loss.visible_again.emplace_back(k, projection.pixel);
    }
  }
  if (next.visibility == Visibility::outside_image) {
    ++frame.lost_outside;
  } else if (!loss.occluded_in_span) {
    ++(near_edge(next.pixel) ? frame.lost_outside : frame.lost_visible);
  } else {
    ++frame.lost;
    if (loss.visible_again.empty()) return;
    ++row(loss.visible_again.front().first).reappeared;
    if (returns && judge(track[i], anchor, track[i + 1], last_seen.points[i + 1]) == Verdict::correct)
      ++row(track[i + 1].frame).recalled;
    else
      book_miss(table_, loss.visible_again, returns ? std::optional(span_end) : std::nullopt, options_, scores_.misses);
  }
}

}  // namespace

TrackScores score_tracks(const TrackTable& table, const SurfaceGroundTruth& ground_truth,
                         const TrackScoreOptions& options) {
  return SurfaceScorer(table, ground_truth, options).score();
}

}  // namespace rastro
