// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rastro/math/se3.h"
#include "rastro/multiview/point_pairs.h"

namespace rastro {

struct AbsolutePoseOptions : CalibratedRansacOptions {
  double huber_px = 1.0;       ///< Huber kernel of the refinement.
  int refine_iterations = 10;  ///< At most.
};

struct AbsolutePose {
  SE3 camera_from_world;
  /// Covariance of d in true pose = exp(d) * camera_from_world, (translation, rotation) in the camera frame, from the
  /// spread of the inliers' errors.
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<std::uint8_t> is_inlier;  ///< One per point.
  int inliers = 0;
  int iterations = 0;   ///< Samples drawn.
  double rms_px = 0.0;  ///< Of the inliers' distances.
};

/// Up to four poses camera_from_world that project three world points to `points` (normalized). Persson and Nordberg
/// 2018, "Lambda Twist: an accurate fast robust perspective three point (P3P) solver".
std::vector<SE3> pose_from_three(std::span<const Eigen::Vector3d, 3> points_in_world,
                                 std::span<const Eigen::Vector2d, 3> points);

/// Pose by RANSAC over three points, refined over the inliers (Gauss-Newton with a Huber kernel). `initial`, where
/// given, is tried before the first sample: a good guess saves samples and a bad one does no harm. `weights`, where not
/// empty: how much each point counts, 1 to 1000, in drawing samples and choosing among them. nullopt for fewer than
/// four points or inliers. The same seed gives the same bits.
std::optional<AbsolutePose> estimate_absolute_pose(std::span<const Eigen::Vector3d> points_in_world,
                                                   std::span<const Eigen::Vector2d> points,
                                                   const AbsolutePoseOptions& options,
                                                   const std::optional<SE3>& initial = std::nullopt,
                                                   std::span<const std::int32_t> weights = {});

/// The refinement alone, from `start`, over all given points; inliers are those within max_error_px afterwards. nullopt
/// for fewer than three points or if they do not determine the pose.
std::optional<AbsolutePose> refine_absolute_pose(std::span<const Eigen::Vector3d> points_in_world,
                                                 std::span<const Eigen::Vector2d> points, const SE3& start,
                                                 const AbsolutePoseOptions& options);

}  // namespace rastro
