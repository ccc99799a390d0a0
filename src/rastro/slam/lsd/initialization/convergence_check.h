// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/slam/lsd/current_keyframe.h"
#include "rastro/slam/lsd/initialization/two_view_start.h"
#include "rastro/slam/lsd/lsd_frame.h"

namespace rastro {

/// Whether depths that began at random are true ones. They may settle on others that fit the images as well, as where
/// the camera moves forward before a wall; so a keyframe's depths are compared with those of two views by features: its
/// own image and that of a later frame.
class ConvergenceCheck {
 public:
  /// `camera`: a pinhole without distortion. `pool` may be null and must outlive this.
  ConvergenceCheck(const TwoViewStartOptions& options, const Camera& camera, TaskPool* pool);

  /// The next frame, tracked on `keyframe`.
  void take(const LsdFrame& frame, const CurrentKeyframe& keyframe);
  /// The frames do not follow each other any more.
  void reset();
  /// Of the depths compared last: median, as a share of them, in the unit that fits best; 0: none yet.
  double difference() const { return difference_; }
  /// Within 10 %, twice in a row: once may be chance, where all is at about the same distance.
  bool has_converged() const { return agreements_ >= 2; }

 private:
  void begin_with(const CurrentKeyframe& keyframe, TimeNs stamp);
  void forget_views();
  void compare(const InverseDepthMap& two_views);

  Camera camera_;
  TwoViewStart two_views_;
  std::optional<CurrentKeyframe> compared_;  ///< Whose image is the first view.
  TimeNs last_stamp_ = 0;
  double difference_ = 0.0;
  int agreements_ = 0;  ///< In a row.
};

}  // namespace rastro
