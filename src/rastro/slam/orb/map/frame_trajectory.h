// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <ranges>
#include <utility>
#include <vector>

#include "rastro/math/packed_se3.h"
#include "rastro/sensor/trajectory.h"
#include "rastro/slam/orb/map/map_graph.h"

namespace rastro {

/// A frame's observation of a landmark.
struct FrameObservation {
  std::int64_t landmark = 0;
  Eigen::Vector2f ray;  ///< Normalized.
  float right = 0.0F;   ///< x in the right camera, normalized; NaN: unknown.
  float sigma = 0.0F;   ///< Normalized.
};

/// A frame's pose relative to a keyframe, from whole images.
struct DirectObservation {
  std::int64_t keyframe = -1;
  RelativePose pose;
};

/// What a frame's pose was estimated from.
struct FrameMeasurements {
  std::vector<FrameObservation> seen;                    ///< Landmarks.
  std::shared_ptr<const DirectObservation> direct = {};  ///< Null: none.
};

/// A frame with a pose relative to a keyframe, so that it follows the keyframe's later corrections.
struct TrackedFrame {
  std::int64_t index = 0;
  TimeNs stamp = 0;
  std::int64_t keyframe = 0;
  double unit = 1.0;  ///< The keyframe's unit when the frame was tracked.
  SE3 camera_from_keyframe;
  std::int64_t became = -1;                                ///< The keyframe made from it; -1: none.
  std::shared_ptr<const FrameMeasurements> measured = {};  ///< Null: it is only remembered.
};

/// Re-estimates the pose from the frame's measurements in the current map; kept with fewer than `least` inliers.
void refine_frame(TrackedFrame& frame, const MapGraph& graph, int least);

/// All frames that have a pose, each index once. Most are only remembered, and these take little memory: a live run has
/// 100,000 in an hour.
class FrameTrajectory {
 public:
  void add(const TrackedFrame& frame);
  /// The camera has the pose of the last frame; false if the stamp does not increase.
  bool repeat_last(std::int64_t index, TimeNs stamp);
  /// The frame became that keyframe.
  void set_keyframe(std::int64_t index, std::int64_t keyframe);
  /// Removes the poses of a submap's frames.
  void forget(const MapGraph& graph, int submap);
  /// As refine_frame(), of all frames.
  void refine(const MapGraph& graph, int least);
  /// So that memory does not grow with time: the frames with measurements except the last `kept` of them, for
  /// refine_frame() beside tracking. They lose their measurements here, not their poses. Empty for fewer than `least`.
  std::vector<TrackedFrame> take_observed(std::size_t kept, std::size_t least);
  /// Sets the poses of frames refined meanwhile; those that are no longer here are left out.
  void put_back(const std::vector<TrackedFrame>& refined);
  /// To save memory: drops the measurements of all frames, and of those added from now on; refine() skips these.
  void forget_observations();
  std::size_t bytes() const;
  /// By index: a random-access view, made as it is read.
  auto frames() const {
    return std::views::iota(std::size_t{0}, poses_.size()) |
           std::views::transform([this](std::size_t k) { return frame(k); });
  }
  /// world_from_camera of the frames whose keyframe is in `submap`, in the order of the recording.
  Trajectory trajectory(const MapGraph& graph, int submap) const;
  /// The submap with most frames, the smallest of equals.
  int largest_submap(const MapGraph& graph) const;

 private:
  /// What is kept of every frame. 32 bits for an index last four years at 30 Hz.
  struct Pose {
    TimeNs stamp;
    double unit;
    PackedSE3 camera_from_keyframe;
    std::uint32_t index;
    std::int32_t keyframe;
  };
  /// By index; few frames have one.
  template <typename T>
  using OfSome = std::vector<std::pair<std::int64_t, T>>;

  static Pose packed(const TrackedFrame& frame);
  TrackedFrame frame(std::size_t k) const;
  void set(std::size_t k, const TrackedFrame& frame);
  /// The number of frames where there is none of that index.
  std::size_t position_of(std::int64_t index) const;
  void make_room();

  std::vector<Pose> poses_;  ///< By index.
  OfSome<std::shared_ptr<const FrameMeasurements>> measured_;
  OfSome<std::int64_t> became_;
  bool keeps_observations_ = true;
};

}  // namespace rastro
