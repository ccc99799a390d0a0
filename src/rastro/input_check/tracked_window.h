// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/image/pyramid.h"
#include "rastro/input_check/pair_depth.h"
#include "rastro/input_check/sample_schedule.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Features of a frame, followed through the next ones.
struct TrackedWindow {
  /// One per feature: its pixel in the first frame and in those after it, as long as it was followed.
  std::vector<std::vector<Eigen::Vector2f>> tracks;
  std::size_t frames = 0;
  /// By a depth camera alone, to find it mirrored: depth in the first frame, meters, one per feature; 0: none. And that
  /// of the pixel mirrored left to right.
  std::vector<float> first_depths, mirrored_depths;
  /// Depths in the first and in the last frame, of a depth camera or by a pair, meters, one per feature; 0: none, or
  /// the feature was lost.
  std::vector<float> start_depths, end_depths;
  double depth_error_growth = 0.003;  ///< Of their relative error with the depth, 1/m.

  /// Features that were followed to the end.
  std::vector<std::size_t> survivors() const;
  /// Median of their motions from the first to the last frame, pixels.
  double motion_px() const;
};

/// Follows features through windows of frames, now and then: until the image has moved enough or most are lost.
class WindowTracker {
 public:
  /// `pair`: to measure depths where the frames have none.
  explicit WindowTracker(std::optional<PairDepth> pair = {}) : schedule_(0, 4.0, 1.25, 250.0), pair_(std::move(pair)) {}

  /// Whether a window ended with this frame.
  bool add(const Frame& frame);
  const TrackedWindow& window() const { return window_; }

 private:
  void start(const Frame& frame);
  void follow(const Frame& frame);
  bool ended() const;
  /// Of features at these pixels, one per feature; `image`: the pyramid of the frame.
  std::vector<float> depths_at(const std::vector<Eigen::Vector2f>& pixels, const Frame& frame, const Pyramid& image);
  void add_end_depths(const Frame& frame);

  SampleSchedule schedule_;
  std::int64_t number_ = 0;
  bool open_ = false;
  Eigen::Vector2i last_size_ = Eigen::Vector2i::Zero();
  TrackedWindow window_;
  std::vector<std::size_t> alive_;
  Pyramid last_, current_;
  std::optional<PairDepth> pair_;
};

}  // namespace rastro
