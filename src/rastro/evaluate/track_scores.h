// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "rastro/evaluate/surface_truth.h"
#include "rastro/track/track_table.h"

namespace rastro {

/// What counts as a loss, a return and the same place.
struct TrackScoreOptions {
  /// A feature last seen in frame a can return in frames a+1 .. a+window. The tracker's own window.
  int window = 30;
  /// Two places of one frame are the same when they are at most this far apart.
  double tolerance_px = 3.0;
  /// Nothing can be detected nearer than this to the image's edge (half of the tracker's 21 px flow window): a
  /// reappearance there is not counted, and a loss there is a loss by leaving the image. Needs the size of the image.
  double border_px = 10.0;
  int image_width = 0;  ///< Pixels; 0 = not known, and then border_px is not used.
  int image_height = 0;
  /// The tracker's spacing of corners, to tell which misses had their place taken.
  double min_distance_px = 30.0;
  /// Frames of the table (by position) that are scored: losses, returns and lengths all inside [first_frame,
  /// end_frame).
  std::int64_t first_frame = 0;
  std::int64_t end_frame = std::numeric_limits<std::int64_t>::max();
  /// score_clean_tracks only: a feature and a clean track are the same within this distance ...
  double same_feature_px = 1.5;
  /// ... in the last frame in which the occluder was at least this far away, so that flow was not yet pulled by it.
  double clearance_px = 10.0;
};

/// The scores of one frame; every count is booked in the frame in which the event is seen.
struct FrameScores {
  std::int64_t index = 0;
  int features = 0, tracked = 0, fresh = 0;
  int reidentified = 0, correct = 0, wrong = 0, unscored = 0;
  int lost = 0, lost_outside = 0, lost_visible = 0, lost_unscored = 0;
  int reappeared = 0;  ///< Features lost to occlusion whose anchor is visible again for the first time.
  int recalled = 0;
};

/// Why features that reappeared did not get their id back, as far as can be told from outside. They add up to the
/// misses.
struct MissReasons {
  int wrong_place = 0;     ///< The id came back, at a wrong place.
  int not_recognised = 0;  ///< A corner was detected at the place and got another id.
  int blocked = 0;  ///< In each frame in which it was visible, another feature held the place within min_distance_px.
  int budget_full = 0;     ///< No corner at all was detected in the frames in which it was visible.
  int never_detected = 0;  ///< Corners were detected elsewhere, none at the place.
};

/// What was wrong with the wrong re-identifications. They add up to `wrong`.
struct WrongReasons {
  int unknown_id = 0;      ///< The id had never been seen before.
  int anchor_outside = 0;  ///< The anchor projects outside the image.
  int anchor_hidden = 0;   ///< The anchor is behind a nearer surface in this frame.
  int other_place = 0;     ///< The anchor is visible, farther than tolerance_px from the corner.
  int on_occluder = 0;     ///< Near enough in the image, but the corner sits on a surface in front of the anchor.
};

/// Scores of a run. With O the observations of an id, in order of frames, and surface(f, p) the truth's surface point
/// at a pixel:
///
/// * A loss (id, a): the id is observed in frame a and not in frame a+1. An id may be lost several times.
/// * Its anchor: surface(a, pixel of the observation in frame a). No surface there (sky): `lost_unscored`.
/// * Its return: the next observation of the id, in frame r <= a + window. Its span: frames a+1 .. r, or to the end of
/// the
///   window where there is no return.
/// * `lost_outside`: in frame a+1 the anchor is outside the image. Else `lost`: a nearer surface hides the anchor in at
/// least one
///   frame of the span (lost to occlusion). Else `lost_outside` again when it is within border_px of the edge in frame
///   a+1; else `lost_visible`.
/// * `reappeared`: of `lost`, those whose anchor is visible, at least border_px inside the image, in a frame j <= a +
/// window
///   after a frame in which it was hidden.
/// * `reidentified`: observations that are marked re-identified or follow a gap, whatever the cause of the loss.
/// `correct`: the
///   anchor is visible in this frame, its reprojection is within tolerance_px of the corner, and the corner's own
///   surface point is the same point: on the same surface, or within tolerance_px of the anchor when projected into the
///   anchor's frame. A corner on an occluder in front of the anchor is therefore wrong. `unscored`: corner or anchor
///   shows no surface. All others are `wrong`.
/// * `recalled`: of `reappeared`, those with a return that is correct. recall = recalled / reappeared;
///   precision = correct / (correct + wrong); no value where there is nothing to count.
/// * `id_switches`: consecutive observations of one id (any state) of which the earlier one's surface point projects
/// farther
///   than tolerance_px from the later one's pixel, or outside the image.
/// * drift: distance of an observation from the reprojection of the surface point of the id's first observation.
///
/// Frames near the end of the scored range have a shorter window: it ends with the range.
struct TrackScores {
  std::string truth;  ///< "surfaces" (score_tracks) or "clean run" (score_clean_tracks).
  int frame_count = 0;
  int lost = 0, lost_outside = 0, lost_visible = 0, lost_unscored = 0;
  int reappeared = 0, recalled = 0;
  int reidentified = 0, correct = 0, wrong = 0, unscored = 0;
  /// Of `unscored`, those of ids seen only on the occluder of a clean run's copy: corners of its own, of which nothing
  /// is asked.
  int unscored_on_occluder = 0;
  std::optional<double> recall, precision;
  MissReasons misses;
  WrongReasons wrongs;
  /// Of `wrong`: those at the place where the id had been observed at another time before it was lost. Such an id had
  /// slipped off its point (onto an occluder's edge, mostly), so that its last observation is not what the user means
  /// by the feature.
  int wrong_but_earlier_place = 0;
  int id_switches = 0;
  int duplicate_ids = 0;  ///< An id twice in one frame: a fault of the tracker; the second one is not scored.
  std::optional<double> drift_median_px, drift_p95_px;
  double drifted_share = 0.0;  ///< Observations farther than tolerance_px from their first one's surface point.
  std::int64_t ids = 0;
  std::optional<double> mean_track_length, median_track_length;  ///< Observations per id.
  std::vector<std::int64_t> length_histogram;                    ///< Ids per bin of length_bins().
  std::vector<FrameScores> frames;
};

/// Lower ends of the bins of TrackScores::length_histogram: 1, 2, 3, 6, 11, 21, 51, 101 observations.
const std::vector<int>& length_bins();

/// Scores a run against exact truth. Frame k of the table is frame k of the truth (see MappedTruth for others).
/// Throws Error when the table has frames that the truth has not, or an option is out of range.
TrackScores score_tracks(const TrackTable& table, const SurfaceTruth& truth, const TrackScoreOptions& options = {});

/// Truth of which each frame of a table shows a chosen one: runs with --frames or --every.
class MappedTruth : public SurfaceTruth {
 public:
  /// Frame k is `truth`'s frame frames[k]. The truth must outlive this.
  MappedTruth(const SurfaceTruth& truth, std::vector<std::int64_t> frames)
      : truth_(truth), frames_(std::move(frames)) {}
  std::int64_t frame_count() const override { return static_cast<std::int64_t>(frames_.size()); }
  std::optional<SurfacePoint> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const override {
    return truth_.surface_at(frames_.at(static_cast<std::size_t>(frame)), pixel);
  }
  Sighting sighting_of(std::int64_t frame, const SurfacePoint& point) const override {
    return truth_.sighting_of(frames_.at(static_cast<std::size_t>(frame)), point);
  }

 private:
  const SurfaceTruth& truth_;
  std::vector<std::int64_t> frames_;
};

}  // namespace rastro
