// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/feature/brief.h"
#include "rastro/image/pyramid.h"
#include "rastro/odometry/rgbd_tracking/feature_tracker.h"
#include "rastro/odometry/rgbd_tracking/point_map.h"

namespace rastro {

/// Finds points of a map anywhere in a frame by their descriptors, for relocalization after a jolt or darkness.
class LandmarkFinder {
 public:
  LandmarkFinder();
  /// Descriptors of the frame's own corners.
  std::vector<Descriptor> describe(const Pyramid& pyramid, const std::vector<Eigen::Vector2f>& corners);
  /// Corners that match one map point and no other, nearest first by point.
  std::vector<FoundPoint> find(const PointMap& map, const Camera& camera, const Pyramid& pyramid,
                               const std::vector<Eigen::Vector2f>& corners);

 private:
  Brief brief_;
  Image<std::uint16_t> sums_;
};

}  // namespace rastro
