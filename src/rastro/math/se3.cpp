// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/se3.h"

namespace rastro {

SE3 SE3::exp(const Vector6d& tangent) {
  const Eigen::Vector3d rotation = tangent.tail<3>();
  return SE3(SO3::exp(rotation), SO3::left_jacobian(rotation) * tangent.head<3>());
}

Vector6d SE3::log() const {
  const Eigen::Vector3d rotation = rotation_.log();
  Vector6d tangent;
  tangent << SO3::left_jacobian_inverse(rotation) * translation_, rotation;
  return tangent;
}

SE3 SE3::inverse() const {
  const SO3 rotation = rotation_.inverse();
  return SE3(rotation, -(rotation * translation_));
}

SE3 SE3::operator*(const SE3& other) const {
  return SE3(rotation_ * other.rotation_, rotation_ * other.translation_ + translation_);
}

Matrix6d SE3::adjoint() const {
  const Eigen::Matrix3d rotation = rotation_.matrix();
  Matrix6d result;
  result << rotation, hat(translation_) * rotation, Eigen::Matrix3d::Zero(), rotation;
  return result;
}

Matrix6d SE3::small_adjoint(const Vector6d& tangent) {
  const Eigen::Matrix3d rotation = hat(tangent.tail<3>());
  Matrix6d result;
  result << rotation, hat(tangent.head<3>()), Eigen::Matrix3d::Zero(), rotation;
  return result;
}

Eigen::Matrix4d SE3::matrix() const {
  Eigen::Matrix4d result = Eigen::Matrix4d::Identity();
  result.topLeftCorner<3, 3>() = rotation_.matrix();
  result.topRightCorner<3, 1>() = translation_;
  return result;
}

SE3 SE3::from_matrix(const Eigen::Matrix4d& matrix) {
  return SE3(SO3::from_matrix(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>());
}

SE3 interpolate(const SE3& a, const SE3& b, double fraction) {
  return a * SE3::exp(fraction * (a.inverse() * b).log());
}

}  // namespace rastro
