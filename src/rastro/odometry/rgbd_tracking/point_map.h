// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/feature/brief.h"
#include "rastro/math/se3.h"
#include "rastro/odometry/rgbd_tracking/depth_reading.h"
#include "rastro/registration/projective_icp.h"
#include "rastro/track/klt.h"

namespace rastro {

/// A feature of the local map: a ray in the reference frame of its first observation, and its depth there.
struct MapPoint {
  int anchor = 0;            ///< Number of the reference.
  Eigen::Vector2d ray;       ///< In the anchor, normalized.
  double inverse_depth = 0;  ///< In the anchor, 1/m; > 0.
  double information = 0;    ///< Of the inverse depth, from depth readings, m^2.
  double readings = 0.0;
  double per_second = 0.0;  ///< Derivative of the mean of the readings by the delay of depth, 1/m/s.
  KltReference patch;
  Descriptor descriptor;
  int seen = 1, missed = 0;                         ///< Frames; missed: in a row, although expected in view.
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< In the last frame.
  bool tracked = false;                             ///< In the last frame.
};

/// A reference frame, against which other frames are tracked.
struct Reference {
  TimeNs stamp = 0;
  SE3 world_from_camera;
  double median_depth = 1.0;
  std::vector<BlockPlane> planes;        ///< Its surfaces; empty without depth, or too old.
  SE3 camera_from_depth;                 ///< Camera motion between color and depth.
  Vector6d velocity = Vector6d::Zero();  ///< Camera velocity at that frame, per second.
};

/// The local map of a depth camera: features of the last reference frames. The poses of all reference frames are kept.
class PointMap {
 public:
  Eigen::Vector3d in_world(const MapPoint& point) const {
    return world_from_anchor(point) *
           Eigen::Vector3d(Eigen::Vector3d(point.ray.x(), point.ray.y(), 1.0) / point.inverse_depth);
  }
  const SE3& world_from_anchor(const MapPoint& point) const {
    return references[static_cast<std::size_t>(point.anchor)].world_from_camera;
  }
  /// Adds a depth reading, seen from the anchor, to the mean.
  static void add_reading(MapPoint& point, const DepthReading& reading);
  /// Drops points whose anchor is older than the last `count` reference frames, and points missed too often.
  void forget(int count, int most_missed);
  /// Increases the estimated delay of depth by this much.
  void delay_depths(double seconds);

  std::vector<Reference> references;  ///< By number.
  std::vector<MapPoint> points;
  int first_live = 0;  ///< Earlier references belong to discarded maps.
};

}  // namespace rastro
