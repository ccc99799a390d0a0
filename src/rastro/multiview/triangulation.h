// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "rastro/math/se3.h"

namespace rastro {

struct TriangulationOptions {
  double focal_px = 500.0;        ///< For errors in pixels.
  double max_error_px = 2.0;      ///< Maximum reprojection error in any view.
  double min_parallax_deg = 0.0;  ///< Minimum of the largest angle between two rays.
};

struct TriangulatedPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< In the first camera's frame, or the world's for many views.
  double parallax_deg = 0.0;                           ///< Largest angle between two rays to it.
  double error_px = 0.0;                               ///< Largest reprojection error.
};

/// The point observed at `a` in the first and at `b` in the second view (normalized): midpoint of the rays, then
/// Gauss-Newton on the reprojection errors. nullopt if it is behind a camera, has too large a reprojection error or too
/// little parallax; parallel rays have no point.
std::optional<TriangulatedPoint> triangulate(const SE3& second_from_first, const Eigen::Vector2d& a,
                                             const Eigen::Vector2d& b, const TriangulationOptions& options);

/// As above for two or more views, in the world frame: `points[i]` is the observation in camera i.
std::optional<TriangulatedPoint> triangulate(std::span<const SE3> world_from_camera,
                                             std::span<const Eigen::Vector2d> points,
                                             const TriangulationOptions& options);

}  // namespace rastro
