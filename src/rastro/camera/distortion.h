// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/camera/camera.h"

namespace rastro {

/// Lens distortion on the plane z = 1: from the undistorted ray (x/z, y/z) to its position in the lens's image. A ray
/// beyond the radius at which the model folds back (its radius stops growing) has no image: nullopt. Not finite:
/// nullopt.
std::optional<Eigen::Vector2d> distort(const Camera& camera, const Eigen::Vector2d& ray);
/// Same, with the derivative of the result by the ray.
std::optional<Eigen::Vector2d> distort(const Camera& camera, const Eigen::Vector2d& ray, Eigen::Matrix2d& jacobian);

/// The ray that distort() maps to `distorted`, to the last digits; nullopt where there is none.
std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& distorted);

/// Radius of the undistorted ray (x/z, y/z) up to which the model grows; infinity if it always does. Beyond it, rays
/// would be imaged on top of inner ones.
double monotonic_radius(const Camera& camera);

}  // namespace rastro
