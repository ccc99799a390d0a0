// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "rastro/odometry/features/local_map.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// The pose of every frame: relative to a keyframe, so that it improves with the keyframe; or predicted; or unknown
/// (yet).
class PoseChain {
 public:
  /// Each returns the index of the frame's record.
  std::size_t add(TimeNs stamp, std::size_t keyframe, const SE3& camera_from_keyframe);
  std::size_t add_unknown(TimeNs stamp);
  /// A frame with the last useful image again: its pose is that one's until the next pose is known. A camera recorded
  /// at twice its rate has moved meanwhile, one at rest has not.
  std::size_t add_repeated(TimeNs stamp);
  /// Predicts the pose from the previous motion.
  std::size_t add_predicted(TimeNs stamp, const LocalMap& map);
  /// The newest pose that is not unknown.
  std::size_t repeat(TimeNs stamp);

  void set(std::size_t record, std::size_t keyframe, const SE3& camera_from_keyframe);
  void set_last(std::size_t keyframe, const SE3& camera_from_keyframe) {
    set(records_.size() - 1, keyframe, camera_from_keyframe);
  }

  /// camera_from_world of the newest frame; the prediction where it is unknown.
  SE3 last_camera_from_world(const LocalMap& map) const;
  SE3 camera_from_world_at(TimeNs stamp, const LocalMap& map) const;
  /// Prediction at the speed of the last two frames with an estimated pose. The rotation continues for two frames at
  /// most, and time under repeated images does not count.
  SE3 predicted(TimeNs stamp, const LocalMap& map) const;
  /// Camera motion between two stamps at the last speed that was not zero; nullopt while there is none: a scale goes on
  /// after a standstill.
  std::optional<double> length_between(TimeNs begin, TimeNs end, const LocalMap& map) const;

  /// world_from_camera of every frame; unknown poses are interpolated between their neighbors.
  Trajectory trajectory(const LocalMap& map) const;

 private:
  enum class Kind { unknown, anchored, guessed };
  struct Record {
    TimeNs stamp = 0;
    Kind kind = Kind::unknown;
    std::size_t keyframe = 0;
    SE3 camera_from_anchor;  ///< Anchor: the keyframe, or the world for a predicted pose.
  };
  std::size_t add(const Record& record);
  void note_anchored(std::size_t record);
  std::optional<SE3> pose_of(const Record& record, const LocalMap& map) const;
  /// The last two frames with an estimated pose, the older first.
  std::optional<std::pair<const Record*, const Record*>> last_two() const;

  std::vector<Record> records_;
  std::vector<std::size_t> anchored_;      ///< Records with an estimated pose, in their order.
  std::optional<std::size_t> last_known_;  ///< The newest record that is not unknown.
  std::size_t last_image_ = 0;             ///< The newest record whose image is not a repeated one.
  TimeNs at_rest_ = 0;                     ///< Time under repeated images since the newest estimated pose.
};

}  // namespace rastro
