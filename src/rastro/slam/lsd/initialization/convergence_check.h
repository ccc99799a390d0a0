// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rastro/slam/lsd/current_keyframe.h"
#include "rastro/slam/lsd/initialization/two_view_start.h"
#include "rastro/slam/lsd/lsd_frame.h"

namespace rastro {

/// Which keyframes have depths that began at random and may not be true ones. They may settle on others that fit the
/// images as well, as where the camera moves forward before a wall; so a keyframe's depths are compared with those of
/// two views by features: its own image and that of a later frame. Ids of keyframes ascend.
class ConvergenceCheck {
 public:
  /// `camera`: a pinhole without distortion. `pool` may be null and must outlive this.
  ConvergenceCheck(const TwoViewStartOptions& options, const Camera& camera, TaskPool* pool);

  /// The depths of this keyframe began at random; those after it follow from them.
  void begin(std::int64_t keyframe);
  /// The next frame, tracked on `keyframe`. True if the depths have converged with it: two keyframes in a row are
  /// within 10 %. One may be by chance, where all is at about the same distance. No keyframe from the first of the two
  /// on is doubtful then.
  bool take(const LsdFrame& frame, const CurrentKeyframe& keyframe);
  /// The frames do not follow each other any more.
  void interrupt();
  bool is_doubtful(std::int64_t keyframe) const;
  /// Of the depths compared last: median, as a share of them, in the unit that fits best; 0: none yet.
  double difference() const { return difference_; }

 private:
  /// Keyframes that began at random and were not confirmed.
  struct Doubtful {
    std::int64_t first = 0, end = 0;
  };

  bool is_followed(const CurrentKeyframe& keyframe);
  void begin_with(const CurrentKeyframe& keyframe, TimeNs stamp);
  void forget_views();
  bool compare(const InverseDepthMap& two_views);

  Camera camera_;
  TwoViewStart two_views_;
  std::optional<CurrentKeyframe> compared_;  ///< Whose image is the first view.
  TimeNs last_stamp_ = 0;
  double difference_ = 0.0;
  std::vector<Doubtful> doubtful_;      ///< Ascending.
  bool is_open_ = false;                ///< The last of them goes on with the next keyframes.
  std::optional<std::int64_t> agreed_;  ///< Keyframe whose depths agreed last.
};

}  // namespace rastro
