// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/map/graph/constraint.h"
#include "rastro/math/se2.h"
#include "rastro/math/se3.h"

namespace rastro {

/// A pose of the plane z = 0 in space.
SE3 in_space(const SE2& pose);
/// The other way: x, y and yaw.
SE2 in_plane(const SE3& pose);
/// Covariance of (x, y, yaw) as one of (translation, rotation); what a planar method cannot move is zero.
Matrix6d in_space(const Eigen::Matrix3d& covariance);

/// A constraint between poses of the plane; `information` is of (x, y, yaw) in the frame of `from`.
Constraint planar_constraint(KeyframeId from, KeyframeId to, const SE2& from_from_to,
                             const Eigen::Matrix3d& information, ConstraintKind kind);

}  // namespace rastro
