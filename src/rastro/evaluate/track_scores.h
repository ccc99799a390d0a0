// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "rastro/evaluate/surface_ground_truth.h"
#include "rastro/track/track_table.h"

namespace rastro {

/// Definition of a loss, a re-identification and a match.
struct TrackScoreOptions {
  /// A feature last observed in frame a can be re-identified in frames a+1 .. a+window. The tracker's own window.
  int window = 30;
  /// Two positions in one frame match if they are at most this far apart.
  double tolerance_px = 3.0;
  /// Nothing can be detected closer than this to the image's edge (half of the tracker's 21 px flow window): a
  /// reappearance there is not counted, and a loss there is a loss by leaving the image. Needs the size of the image.
  double border_px = 10.0;
  int image_width = 0;  ///< Pixels; 0: unknown, and then border_px is not used.
  int image_height = 0;
  /// The tracker's minimum distance of features, to tell which misses had their position taken.
  double min_distance_px = 30.0;
  /// Frames of the table (by index) that are scored: losses, re-identifications and lengths all inside [first_frame,
  /// end_frame).
  std::int64_t first_frame = 0;
  std::int64_t end_frame = std::numeric_limits<std::int64_t>::max();
  /// score_clean_tracks only: a feature and a clean track match within this distance ...
  double same_feature_px = 1.5;
  /// ... in the last frame in which the occluder was at least this far away, so that optical flow was not yet dragged
  /// by it.
  double clearance_px = 10.0;
};

/// Counts of events, in one frame or in a whole run.
struct TrackCounts {
  int reidentified = 0, correct = 0, wrong = 0, unscored = 0;
  int lost = 0, lost_outside = 0, lost_visible = 0, lost_unscored = 0;
  int reappeared = 0;  ///< Features lost to occlusion whose anchor is visible again for the first time.
  int recalled = 0;

  TrackCounts& operator+=(const TrackCounts& other);
};

/// The scores of one frame; every event is counted in the frame in which it is observed.
struct FrameScores : TrackCounts {
  std::int64_t index = 0;
  int features = 0, tracked = 0, fresh = 0;
};

/// Why features that reappeared were not re-identified, as far as can be told from outside. They add up to the misses.
struct MissReasons {
  int wrong_position = 0;    ///< The id was re-identified at a wrong position.
  int not_reidentified = 0;  ///< A feature was detected at the position and got another id.
  int blocked = 0;           ///< In each frame in which it was visible, another feature was within min_distance_px.
  int budget_full = 0;       ///< No feature at all was detected in the frames in which it was visible.
  int never_detected = 0;    ///< Corners were detected elsewhere, none at the position.
};

/// What was wrong with the wrong re-identifications. They add up to `wrong`.
struct WrongReasons {
  int unknown_id = 0;       ///< The id had never been observed before.
  int anchor_outside = 0;   ///< The anchor projects outside the image.
  int anchor_occluded = 0;  ///< The anchor is occluded by a nearer surface in this frame.
  int other_position = 0;   ///< The anchor is visible, farther than tolerance_px from the feature.
  int on_occluder = 0;      ///< Close enough in the image, but the feature is on a surface in front of the anchor.
};

/// Scores of a run. With O the observations of an id, in order of frames, and surface(f, p) the true surface point at a
/// pixel:
///
/// * A loss (id, a): the id is observed in frame a and not in frame a+1. An id may be lost several times.
/// * Its anchor: surface(a, pixel of the observation in frame a). No surface there (sky): `lost_unscored`.
/// * Its re-identification: the next observation of the id, in frame r <= a + window. Its span: frames a+1 .. r, or to
/// the end of the
///   window without one.
/// * `lost_outside`: in frame a+1 the anchor is outside the image. Else `lost`: a nearer surface occludes the anchor in
/// at least one
///   frame of the span (lost to occlusion). Else `lost_outside` again if it is within border_px of the edge in frame
///   a+1; else `lost_visible`.
/// * `reappeared`: of `lost`, those whose anchor is visible, at least border_px inside the image, in a frame j <= a +
/// window
///   after a frame in which it was occluded.
/// * `reidentified`: observations that are marked re-identified or follow a gap, whatever the cause of the loss.
/// `correct`: the
///   anchor is visible in this frame, its reprojection is within tolerance_px of the feature, and the feature's own
///   surface point is the same point: on the same surface, or within tolerance_px of the anchor when projected into the
///   anchor's frame. A feature on an occluder in front of the anchor is therefore wrong. `unscored`: feature or anchor
///   shows no surface. All others are `wrong`.
/// * `recalled`: of `reappeared`, those with a correct re-identification. recall = recalled / reappeared;
///   precision = correct / (correct + wrong); no value where there is nothing to count.
/// * `id_switches`: consecutive observations of one id (any state) of which the earlier one's surface point projects
/// farther
///   than tolerance_px from the later one's pixel, or outside the image.
/// * drift: distance of an observation from the reprojection of the surface point of the id's first observation.
///
/// Frames near the end of the scored range have a shorter window: it ends with the range.
struct TrackScores : TrackCounts {
  std::string ground_truth;  ///< "surfaces" (score_tracks) or "clean run" (score_clean_tracks).
  int frame_count = 0;
  /// Of `unscored`, those of ids observed only on the occluder of a clean run's copy: its own corners, which are not
  /// scored.
  int unscored_on_occluder = 0;
  std::optional<double> recall, precision;
  MissReasons misses;
  WrongReasons wrongs;
  /// Of `wrong`: those at the position of an earlier observation of the id. Such an id had slipped off its point
  /// (mostly onto an occluder's edge), so its last observation is not what the user means by the feature.
  int wrong_but_earlier_position = 0;
  int id_switches = 0;
  int duplicate_ids = 0;  ///< An id twice in one frame: a fault of the tracker; the second one is not scored.
  std::optional<double> drift_median_px, drift_p95_px;
  double drifted_share = 0.0;  ///< Observations farther than tolerance_px from the surface point of their first one.
  std::int64_t ids = 0;
  std::optional<double> mean_track_length, median_track_length;  ///< Observations per id.
  std::vector<std::int64_t> length_histogram;                    ///< Ids per bin of length_bins().
  std::vector<FrameScores> frames;
};

/// Lower ends of the bins of TrackScores::length_histogram: 1, 2, 3, 6, 11, 21, 51, 101 observations.
const std::vector<int>& length_bins();

/// Scores a run against exact ground truth. Frame k of the table is frame k of the ground truth (see MappedGroundTruth
/// for others). Throws Error if the table has frames that the ground truth lacks, or an option is out of range.
TrackScores score_tracks(const TrackTable& table, const SurfaceGroundTruth& ground_truth,
                         const TrackScoreOptions& options = {});

/// Ground truth for a table whose frames are a selection: runs with --frames or --every.
class MappedGroundTruth : public SurfaceGroundTruth {
 public:
  /// Frame k is frame frames[k] of `ground_truth`, which must outlive this.
  MappedGroundTruth(const SurfaceGroundTruth& ground_truth, std::vector<std::int64_t> frames)
      : ground_truth_(ground_truth), frames_(std::move(frames)) {}
  std::int64_t frame_count() const override { return static_cast<std::int64_t>(frames_.size()); }
  std::optional<SurfacePoint> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const override {
    return ground_truth_.surface_at(frames_.at(static_cast<std::size_t>(frame)), pixel);
  }
  ProjectedPoint project(std::int64_t frame, const SurfacePoint& point) const override {
    return ground_truth_.project(frames_.at(static_cast<std::size_t>(frame)), point);
  }

 private:
  const SurfaceGroundTruth& ground_truth_;
  std::vector<std::int64_t> frames_;
};

}  // namespace rastro
