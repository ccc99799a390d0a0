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

/// Where a frame sees a point of the map.
struct FoundPoint {
  std::size_t point = 0;  ///< Index in the map.
  Eigen::Vector2f pixel;
  Eigen::Vector2d ray;     ///< Normalised.
  bool recognised = true;  ///< By its looks in the anchor; else only carried on from the frame before.
};

/// Finds the points of a map in frames. Results do not depend on the pool.
class FeatureTracker {
 public:
  FeatureTracker(const RgbdOptions& options, const Camera& camera, TaskPool* pool)
      : options_(options), camera_(camera), pool_(pool) {}

  /// The next image. The one before it is kept for carry_on().
  void take(const Frame& frame);
  /// Points tracked in the frame before, by optical flow, starting where `guess` would see them.
  std::vector<FoundPoint> carry_on(const PointMap& map, const SE3& guess) const;
  /// All points that a camera at `pose` could see, by their looks in their anchors, those of old anchors first, so that
  /// nothing drifts; `carried` stay where they were found when their looks have changed too much. Marks the map's
  /// points as tracked or missed.
  std::vector<FoundPoint> recognise(PointMap& map, const SE3& pose, const std::vector<FoundPoint>& carried);
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
  GreyImage free_;
};

}  // namespace rastro
