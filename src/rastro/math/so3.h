// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace rastro {

/// Rotation in space, kept as a unit Hamilton quaternion. Tangent vectors are rotation vectors in radians.
class SO3 {
 public:
  SO3() : quaternion_(Eigen::Quaterniond::Identity()) {}
  /// Normalises; the quaternion must not be zero.
  explicit SO3(const Eigen::Quaterniond& quaternion) : quaternion_(quaternion.normalized()) {}
  /// The nearest rotation to `matrix`.
  static SO3 from_matrix(const Eigen::Matrix3d& matrix);

  static SO3 exp(const Eigen::Vector3d& tangent);
  Eigen::Vector3d log() const;
  SO3 inverse() const { return SO3(quaternion_.conjugate()); }
  SO3 operator*(const SO3& other) const { return SO3(quaternion_ * other.quaternion_); }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return quaternion_ * point; }
  Eigen::Matrix3d adjoint() const { return matrix(); }
  Eigen::Matrix3d matrix() const { return quaternion_.toRotationMatrix(); }
  const Eigen::Quaterniond& quaternion() const { return quaternion_; }

 private:
  Eigen::Quaterniond quaternion_;
};

SO3 interpolate(const SO3& a, const SO3& b, double fraction);

}  // namespace rastro
