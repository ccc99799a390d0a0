// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "rastro/slam/lsd/initialization/two_view_start.h"
#include "rastro/slam/lsd/lsd_frame.h"
#include "rastro/slam/lsd/lsd_mapping.h"
#include "rastro/slam/lsd/pose_search.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Of the features that depths begin with, or are compared with.
TwoViewStartOptions two_view_options(const LsdOptions& options);

/// Begins a map: with the depths that a pair or a depth camera measures, or of one camera with those of two views or
/// random ones.
class LsdStart {
 public:
  /// Options, sensor and frames outlive this.
  LsdStart(const LsdOptions& options, const LsdSensor& sensor, const LsdFrameMaker& frames, TaskPool* pool);

  /// The next frame without a map. Once a new submap has begun: the frame's pose relative to its first keyframe, or,
  /// where the frame does not fit and the update says `lost`, that of the last one before that does. The search
  /// remembers the last frame that was tracked.
  std::optional<SE3> take(const LsdFrame& frame, LsdMapping& mapping, PoseSearch& search, SlamUpdate& update);
  /// The camera was found elsewhere.
  void reset() { two_views_.reset(); }

 private:
  std::optional<SE3> from_two_views(const LsdFrame& frame, LsdMapping& mapping, PoseSearch& search, SlamUpdate& update);
  std::optional<SE3> from_sensor(const LsdFrame& frame, LsdMapping& mapping, PoseSearch& search, SlamUpdate& update);
  static SE3 from_one_frame(const LsdFrame& frame, KeyframeDepths first, LsdMapping& mapping, PoseSearch& search,
                            SlamUpdate& update);
  struct FollowedFrames {
    SE3 last;             ///< Pose of the last one that fits.
    bool newest = false;  ///< Whether that is the newest one.
  };
  FollowedFrames follow_kept_frames(std::size_t first, LsdMapping& mapping, PoseSearch& search);
  std::optional<SE3> follow_kept(std::size_t k, const SE3& guess, LsdMapping& mapping, PoseSearch& search,
                                 bool is_before, std::vector<PlacedFrame>& placed) const;

  const LsdOptions& options_;
  const LsdSensor& sensor_;
  const LsdFrameMaker& frames_;
  TwoViewStart two_views_;
};

}  // namespace rastro
