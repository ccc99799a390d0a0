// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/evaluate/track_scores.h"

namespace rastro {

/// The pixels of a recorded sequence that a drawn-in occluder covers.
class OccluderCover {
 public:
  virtual ~OccluderCover() = default;
  /// True if the occluder covers anything within `radius_px` of the pixel. Frames are positions in the occluded run's
  /// table.
  virtual bool covered(std::int64_t frame, const Eigen::Vector2d& pixel, double radius_px) const = 0;
};

/// Scores a run on an occluded copy of a recording against a run on the clean recording, whose tracks serve as ground
/// truth. Frames are paired by stamp. The clean run should have many features close together (`--mode klt --features
/// 1500 --set min_distance_px=5`), so that most features of the occluded run have a counterpart.
///
/// A segment is a part of a clean track over consecutive frames in which optical flow alone tracked it. The counterpart
/// of an observation in frame a: in the id's last clear frame u <= a (no occluder within clearance_px of it; not
/// further back than the window, over consecutive observations), the segment nearest to it in frame u, within
/// same_feature_px.
/// * loss (id, a), span, window: as in TrackScores.
/// * `lost`: the counterpart's position is covered in at least one frame of the span; `lost_outside`: else if the
/// segment ends and
///   its last position is within border_px of the edge; `lost_visible`: else; `lost_unscored`: no counterpart, or it
///   ends
///   in the window before the position is uncovered again (and the image's edge is not the reason).
/// * `reappeared`: of `lost`, the counterpart is tracked to a frame of the window in which its position is uncovered
/// again, at
///   least border_px inside the image.
/// * a re-identified feature is `correct` if it lies within tolerance_px of the counterpart and no occluder covers the
///   counterpart's position or the feature; `unscored` without a counterpart that reaches this frame; else `wrong`. An
///   id
///   observed only on the occluder, and then clear of it, is `wrong` too.
/// * recall, precision and the rest: as in TrackScores. id_switches counts consecutive observations of one id with a
/// counterpart in
///   both frames, farther than tolerance_px from the counterpart in the later frame.
///
/// Without `cover` (null) the cause of a loss is unknown: every loss whose counterpart is tracked further counts as
/// `lost`, and as reappeared if the counterpart is present two frames later or more. Throws Error if the runs share no
/// frame.
TrackScores score_clean_tracks(const TrackTable& occluded, const TrackTable& clean, const OccluderCover* cover,
                               const TrackScoreOptions& options = {});

}  // namespace rastro
