// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/pose_uncertainty.h"

#include "rastro/slam/lsd/semi_dense_graph.h"

namespace rastro {
namespace {

/// An error of the rotation moves what is at a distance.
Matrix6d moved(const Matrix6d& covariance, const Eigen::Vector3d& shift) {
  Matrix6d by = Matrix6d::Identity();
  by.topRightCorner<3, 3>() = -hat(shift);
  return by * covariance * by.transpose();
}

/// From d of image_from_keyframe * exp(d) to errors of world_from_camera in the world's axes.
Matrix6d in_world(const Matrix6d& covariance, const SE3& image_from_keyframe, double unit,
                  const SO3& world_from_camera) {
  Matrix6d by = Matrix6d::Zero();
  by.topLeftCorner<3, 3>() = unit * world_from_camera.matrix();
  by.bottomRightCorner<3, 3>() = world_from_camera.matrix();
  by = (by * image_from_keyframe.adjoint()).eval();
  return by * covariance * by.transpose();
}

}  // namespace

void PoseUncertainty::set_known(std::int64_t keyframe, const Eigen::Vector3d& position) {
  keyframes_[keyframe] = {position, Matrix6d::Zero()};
}

void PoseUncertainty::set(std::int64_t keyframe, const Eigen::Vector3d& position, const Matrix6d& covariance) {
  keyframes_[keyframe] = {position, covariance};
}

Matrix6d PoseUncertainty::of_frame(std::int64_t keyframe, double unit, double mean_inverse_depth,
                                   const SE3& world_from_camera, const ImageAlignment& alignment) const {
  const Matrix6d own = alignment.covariance + common_covariance(mean_inverse_depth);
  Matrix6d sum = in_world(own, alignment.image_from_reference, unit, world_from_camera.rotation());
  const auto placed = keyframes_.find(keyframe);
  if (placed != keyframes_.end())
    sum += moved(placed->second.covariance, world_from_camera.translation() - placed->second.position);
  return 0.5 * (sum + sum.transpose());
}

}  // namespace rastro
