// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/feature/corner.h"
#include "rastro/image/pyramid.h"
#include "rastro/odometry/rgbd_tracking/options.h"
#include "rastro/odometry/rgbd_tracking/point_map.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Observation of a map point in a frame.
struct FoundPoint {
  std::size_t point = 0;  ///< Index in the map.
  Eigen::Vector2f pixel;
  Eigen::Vector2d ray;     ///< Normalized.
  bool recognized = true;  ///< Matched with the anchor's patch; else only tracked from the previous frame.
};

/// Finds the points of a map in frames. Results do not depend on the pool.
class FeatureTracker {
 public:
  FeatureTracker(const RgbdOptions& options, const Camera& camera, TaskPool* pool)
      : options_(options), camera_(camera), pool_(pool) {}

  /// Sets the next image. The previous one is kept for carry_on().
  void take(const Frame& frame);
  /// Tracks the previous frame's points by optical flow, starting at their projections by `guess`.
  std::vector<FoundPoint> carry_on(const PointMap& map, const SE3& guess) const;
  /// Matches all points visible from a camera at `pose` with the patches of their anchors, those of old anchors first,
  /// to avoid drift. A point of `carried` keeps its position if its patch has changed too much. Marks the map's points
  /// as tracked or missed.
  std::vector<FoundPoint> recognize(PointMap& map, const SE3& pose, const std::vector<FoundPoint>& carried);
  /// Corners away from `found`, strongest first.
  std::vector<Eigen::Vector2f> new_corners(const Frame& frame, const std::vector<FoundPoint>& found, int count);
  const Pyramid& pyramid() const { return current_; }

 private:
  struct Candidate;
  std::vector<Candidate> in_view(const PointMap& map, const SE3& pose, const std::vector<FoundPoint>& carried) const;
  KltOptions flow_options() const;

  const RgbdOptions& options_;
  const Camera& camera_;
  TaskPool* pool_;
  Pyramid previous_, current_;
  CornerDetector detector_;
  GrayImage free_;
};

}  // namespace rastro
