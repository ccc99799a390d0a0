// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/map/graph/constraint.h"
#include "rastro/math/se2.h"
#include "rastro/math/se3.h"

namespace rastro {

/// A pose of the plane z = 0 as a 3D pose.
SE3 in_space(const SE2& pose);
/// The inverse: x, y and yaw.
SE2 in_plane(const SE3& pose);
/// Covariance of (x, y, yaw) as one of (translation, rotation); components that a planar method fixes are zero.
Matrix6d in_space(const Eigen::Matrix3d& covariance);
/// The inverse: the part of a covariance or information of (translation, rotation) that is about (x, y, yaw).
Eigen::Matrix3d in_plane(const Matrix6d& covariance);

/// A constraint between planar poses; `information` is of (x, y, yaw) in the frame of `from`.
Constraint planar_constraint(KeyframeId from, KeyframeId to, const SE2& from_from_to,
                             const Eigen::Matrix3d& information, ConstraintKind kind);

}  // namespace rastro
