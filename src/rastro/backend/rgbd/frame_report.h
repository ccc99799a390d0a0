// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/math/se3.h"
#include "rastro/odometry/odometry.h"
#include "rastro/odometry/rgbd_tracking/rgbd_follower.h"
#include "rastro/sensor/frame.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// What the follower says of a frame, in the words of SLAM.
SlamReason reason_of(OdometryReason reason);
ObservationState state_of(FollowedFeature::State state);

/// What the map's files and images need of a frame.
Frame kept_of(const Frame& frame);

/// Covariance of a * b, in the tangent space at its right, from those of a and b at theirs.
Matrix6d chained(const Matrix6d& of_a, const SE3& b, const Matrix6d& of_b);
/// Of the motion back from b to a.
Matrix6d of_inverse(const Matrix6d& of_a, const SE3& a);
/// Inverse, symmetric to the last bit.
Matrix6d information_of(const Matrix6d& covariance);
/// From the tangent space at the right of the pose to errors in the world's axes.
Matrix6d in_world_axes(const Matrix6d& covariance, const SE3& pose);

}  // namespace rastro
