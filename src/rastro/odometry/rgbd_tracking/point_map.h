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

/// A feature of the local map: a ray of the reference it was first seen in, and how deep it lies there.
struct MapPoint {
  int anchor = 0;            ///< Number of the reference.
  Eigen::Vector2d ray;       ///< In the anchor, normalised.
  double inverse_depth = 0;  ///< In the anchor, 1/m; > 0.
  double information = 0;    ///< Of that by depth readings, m^2.
  double readings = 0.0;
  double per_second = 0.0;  ///< Change of the mean of the readings with the delay of depth, 1/m/s.
  KltReference patch;
  Descriptor descriptor;
  int seen = 1, missed = 0;                         ///< Frames; missed: in a row, although it should have been in view.
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< In the last frame.
  bool tracked = false;                             ///< In the last frame.
};

/// A frame that others are followed against.
struct Reference {
  TimeNs stamp = 0;
  SE3 world_from_camera;
  double median_depth = 1.0;
  std::vector<BlockPlane> planes;        ///< Its surfaces; empty where it has none, or is too old.
  SE3 camera_from_depth;                 ///< How the camera moved between colour and depth.
  Vector6d velocity = Vector6d::Zero();  ///< Of the camera then, per second.
};

/// The local map of a depth camera: features of the last references. All references' poses are kept.
class PointMap {
 public:
  Eigen::Vector3d in_world(const MapPoint& point) const {
    return world_from_anchor(point) *
           Eigen::Vector3d(Eigen::Vector3d(point.ray.x(), point.ray.y(), 1.0) / point.inverse_depth);
  }
  const SE3& world_from_anchor(const MapPoint& point) const {
    return references[static_cast<std::size_t>(point.anchor)].world_from_camera;
  }
  /// Takes one more reading of the depth, seen from the anchor, into the mean.
  static void add_reading(MapPoint& point, const DepthReading& reading);
  /// Drops points whose anchor is older than the last `count` references, and points missed too often.
  void forget(int count, int most_missed);
  /// Depth is now thought to have been taken so much later.
  void delay_depths(double seconds);

  std::vector<Reference> references;  ///< By number.
  std::vector<MapPoint> points;
  int first_live = 0;  ///< References before this one belong to maps given up.
};

}  // namespace rastro
