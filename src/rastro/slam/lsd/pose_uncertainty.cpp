// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/pose_uncertainty.h"

#include "rastro/slam/lsd/semi_dense_graph.h"

namespace rastro {
namespace {

/// From d of image_from_keyframe * exp(d) to errors of world_from_camera in the world's axes.
Matrix6d in_world(const Matrix6d& covariance, const AlignedFrame& frame) {
  const Eigen::Matrix3d world_from_camera = frame.world_from_camera.rotation().matrix();
  Matrix6d by = Matrix6d::Zero();
  by.topLeftCorner<3, 3>() = frame.unit * world_from_camera;
  by.bottomRightCorner<3, 3>() = world_from_camera;
  by = (by * frame.alignment.image_from_reference.adjoint()).eval();
  return by * covariance * by.transpose();
}

}  // namespace

void PoseUncertainty::set_known(std::int64_t keyframe, const Eigen::Vector3d& position) {
  keyframes_.set(keyframe, position, Matrix6d::Zero());
  shortening_[keyframe] = {position, Eigen::Vector3d::Zero()};
}

void PoseUncertainty::add(std::int64_t keyframe, const Eigen::Vector3d& position, const AlignedFrame& frame) {
  if (keyframes_.contains(keyframe)) return;
  const auto from = shortening_.find(frame.keyframe);
  const Eigen::Vector3d step = position - (from == shortening_.end() ? position : from->second.position);
  shortening_[keyframe] = {position, shortening_of(frame)};
  // What all images have in common counts once, in of_frame(), but for a part that changes from view to view.
  constexpr double changing = 0.15;
  const Matrix6d own =
      errors_.alike * frame.alignment.covariance + changing * common_covariance(frame.mean_inverse_depth);
  Matrix6d of_step = in_world(own, frame);
  const Eigen::Vector3d missing = errors_.attenuation_of_step * frame.attenuation * step;
  of_step.topLeftCorner<3, 3>() += missing * missing.transpose();
  keyframes_.add(keyframe, frame.keyframe, position, of_step, errors_.scale_drift * errors_.scale_drift);
}

void PoseUncertainty::join(std::int64_t keyframe, const Eigen::Vector3d& position, std::int64_t earlier,
                           const Matrix6d& covariance, double scale_variance) {
  const auto from = shortening_.find(earlier);
  if (from == shortening_.end()) return;
  shortening_[keyframe] = {position, from->second.sum};
  keyframes_.add(keyframe, earlier, position, errors_.alike * covariance, scale_variance);
}

Eigen::Vector3d PoseUncertainty::shortening_of(const AlignedFrame& frame) const {
  const auto from = shortening_.find(frame.keyframe);
  if (from == shortening_.end()) return Eigen::Vector3d::Zero();
  return from->second.sum + frame.attenuation * (frame.world_from_camera.translation() - from->second.position);
}

Matrix6d PoseUncertainty::of_frame(const AlignedFrame& frame) const {
  const Matrix6d own = errors_.alike * frame.alignment.covariance + common_covariance(frame.mean_inverse_depth);
  const Eigen::Vector3d position = frame.world_from_camera.translation();  // from the first keyframe
  Matrix6d covariance = keyframes_.of_pose(frame.keyframe, position, in_world(own, frame));
  const double scale_variance = errors_.scale * errors_.scale + frame.scale_error * frame.scale_error;
  covariance.topLeftCorner<3, 3>() += scale_variance * position * position.transpose();
  const Eigen::Vector3d shortening = errors_.attenuation * shortening_of(frame);
  covariance.topLeftCorner<3, 3>() += shortening * shortening.transpose();
  return covariance;
}

}  // namespace rastro
