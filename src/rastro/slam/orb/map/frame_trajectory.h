// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/sensor/trajectory.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// A landmark as a frame observed it.
struct FrameObservation {
  std::int64_t landmark = 0;
  Eigen::Vector2f ray;  ///< Normalised.
  float right = 0.0F;   ///< Of the right camera; NaN: unknown.
  float sigma = 0.0F;   ///< Normalised.
};

/// A frame with a pose, relative to a keyframe, so that it follows where that goes later.
struct TrackedFrame {
  std::int64_t index = 0;
  TimeNs stamp = 0;
  std::int64_t keyframe = 0;
  SE3 camera_from_keyframe;
  double unit = 1.0;                   ///< The keyframe's when the frame was tracked.
  std::int64_t became = -1;            ///< The keyframe made of it.
  std::vector<FrameObservation> seen;  ///< What its pose rests on.
};

/// All frames that have a pose.
class FrameTrajectory {
 public:
  void add(const TrackedFrame& frame);
  /// The camera is where it was at the last frame; false where the stamp does not go on.
  bool repeat_last(std::int64_t index, TimeNs stamp);
  /// The frame became that keyframe.
  void set_keyframe(std::int64_t index, std::int64_t keyframe);
  /// Frames of a submap have no pose any more.
  void forget(const MapGraph& graph, int submap);
  /// Estimates every pose anew by what the frame saw of the map as it now is; a frame of which fewer than `least`
  /// landmarks still fit stays.
  void refine(const MapGraph& graph, int least);
  const std::vector<TrackedFrame>& frames() const { return frames_; }
  /// world_from_camera of the frames whose keyframe stands in `submap`, in the order of the recording.
  Trajectory trajectory(const MapGraph& graph, int submap) const;
  /// The submap with most frames, the smallest of equals.
  int largest_submap(const MapGraph& graph) const;

 private:
  std::vector<TrackedFrame> frames_;  ///< By index.
};

}  // namespace rastro
