// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"

namespace rastro {

/// One keyframe with its images loaded, for measuring.
struct LengthView {
  std::int64_t keyframe = 0;
  SE3 world_from_camera;
  Camera camera;
  GrayImage gray;
  DepthImage depth;
  double depth_sigma_m = 0.0, depth_sigma_per_m2 = 0.0;  ///< As in DepthNoise.

  bool has_depth() const;  ///< Of any pixel.
  /// Standard deviation of a measured depth, meters.
  double depth_sigma(double z) const { return depth_sigma_m + depth_sigma_per_m2 * z * z; }
};

/// Search box of a flat face, in the camera frame.
struct LengthRegion {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns: along the edge, into the face, normal of the face.
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();  ///< Along the axes, meters.
  bool normal_known = true;  ///< The third axis is within about 35 degrees of the face's normal.
};

/// A flat face in one depth image, in the camera frame: 1 / z = inverse . (x / z, y / z, 1). In inverse depth the noise
/// of structured light and of stereo is uniform, and a plane is linear.
struct LengthFace {
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of `inverse`.
  int points = 0;                                        ///< Number of pixels on it.
  double support = 0.0;     ///< Their share of the region's pixels that face it: low where depth is missing or behind.
  double residual_m = 0.0;  ///< Scatter of their depths.

  Eigen::Vector3d normal() const { return inverse.normalized(); }
  /// Depth along a ray (x / z, y / z, 1), meters.
  double depth_at(const Eigen::Vector3d& ray) const { return 1.0 / inverse.dot(ray); }
  /// Standard deviation of that depth.
  double depth_sigma_at(const Eigen::Vector3d& ray) const;
  /// Signed distance of a point in the camera frame, meters, positive behind the face.
  double behind(const Eigen::Vector3d& point) const { return (inverse.dot(point) - 1.0) / inverse.norm(); }
  /// Closest point on the face.
  Eigen::Vector3d foot(const Eigen::Vector3d& point) const { return point - behind(point) * normal(); }
};

/// The face with the most pixels inside the region, fitted robustly; nullopt if too few pixels are on it. `seed`
/// determines the drawn samples.
std::optional<LengthFace> find_face(const LengthView& view, const LengthRegion& region, std::uint64_t seed);

}  // namespace rastro
