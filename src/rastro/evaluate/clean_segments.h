// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/track/track_table.h"

namespace rastro {

/// A segment of a clean track: consecutive frames of the occluded run in which optical flow alone tracked it.
struct CleanSegment {
  std::int64_t first = 0;  ///< Frame of positions[0]: index in the occluded run's table.
  std::vector<Eigen::Vector2d> positions;

  std::int64_t last() const { return first + static_cast<std::int64_t>(positions.size()) - 1; }
  std::optional<Eigen::Vector2d> at(std::int64_t frame) const {
    if (frame < first || frame > last()) return std::nullopt;
    return positions[static_cast<std::size_t>(frame - first)];
  }
};

/// The segments of a clean run, in the frames of an occluded run of the same recording (paired by stamp).
class CleanSegments {
 public:
  /// Throws Error if the runs share no stamp.
  CleanSegments(const TrackTable& occluded, const TrackTable& clean);

  /// The segment nearest to `pixel` in `frame`, within `radius_px`; null if there is none. Equally near: the earlier
  /// one.
  const CleanSegment* nearest(std::int64_t frame, const Eigen::Vector2d& pixel, double radius_px) const;
  std::int64_t shared_frames() const { return shared_frames_; }

 private:
  std::vector<CleanSegment> segments_;
  std::vector<std::vector<std::size_t>> in_frame_;  ///< Segments in each frame of the occluded run.
  std::int64_t shared_frames_ = 0;
};

}  // namespace rastro
