// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/frame_report.h"

#include <Eigen/LU>

namespace rastro {

SlamReason reason_of(OdometryReason reason) {
  switch (reason) {
    case OdometryReason::none:
    case OdometryReason::no_motion:
    case OdometryReason::pure_rotation:
      return SlamReason::none;
    case OdometryReason::first_frame:
      return SlamReason::first_frame;
    case OdometryReason::too_few_points:
      return SlamReason::too_few_points;
    case OdometryReason::dark_or_blank:
      return SlamReason::dark_or_blank;
    case OdometryReason::blurred:
      return SlamReason::blurred;
    case OdometryReason::repeated_frame:
      return SlamReason::repeated_frame;
    case OdometryReason::gap:
      return SlamReason::gap;
    case OdometryReason::too_little_parallax:
    case OdometryReason::few_inliers:
    case OdometryReason::calibration_doubtful:
      return SlamReason::few_inliers;
  }
  return SlamReason::none;
}

ObservationState state_of(FollowedFeature::State state) {
  switch (state) {
    case FollowedFeature::State::matched:
      return ObservationState::matched;
    case FollowedFeature::State::inlier:
      return ObservationState::inlier;
    case FollowedFeature::State::outlier:
      return ObservationState::outlier;
    case FollowedFeature::State::fresh:
      return ObservationState::new_landmark;
  }
  return ObservationState::unmatched;
}

Frame kept_of(const Frame& frame) {
  Frame kept;
  kept.index = frame.index;
  kept.stamp = frame.stamp;
  kept.image = frame.image;
  kept.color.rgb = frame.color.rgb;
  kept.depth = frame.depth;
  kept.mask = frame.mask;
  return kept;
}

Matrix6d chained(const Matrix6d& of_a, const SE3& b, const Matrix6d& of_b) {
  const Matrix6d adjoint = b.inverse().adjoint();
  const Matrix6d sum = adjoint * of_a * adjoint.transpose() + of_b;
  return 0.5 * (sum + sum.transpose());
}

Matrix6d of_inverse(const Matrix6d& of_a, const SE3& a) {
  const Matrix6d adjoint = a.adjoint();
  return adjoint * of_a * adjoint.transpose();
}

Matrix6d information_of(const Matrix6d& covariance) {
  const Matrix6d information = covariance.inverse();
  return 0.5 * (information + information.transpose());
}

Matrix6d in_world_axes(const Matrix6d& covariance, const SE3& pose) {
  Matrix6d rotation = Matrix6d::Zero();
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = pose.rotation().matrix();
  const Matrix6d rotated = rotation * covariance * rotation.transpose();
  return 0.5 * (rotated + rotated.transpose());
}

}  // namespace rastro
