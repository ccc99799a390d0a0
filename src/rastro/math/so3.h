// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace rastro {

/// The matrix of the cross product: hat(a) * b = a x b.
Eigen::Matrix3d hat(const Eigen::Vector3d& vector);

/// Rotation in space, kept as a unit Hamilton quaternion. Tangent vectors are rotation vectors in radians.
/// Sola et al. 2018, "A micro Lie theory for state estimation in robotics".
class SO3 {
 public:
  using Tangent = Eigen::Vector3d;
  using Point = Eigen::Vector3d;

  SO3() : quaternion_(Eigen::Quaterniond::Identity()) {}
  /// Normalizes; the quaternion must not be zero.
  explicit SO3(const Eigen::Quaterniond& quaternion) : quaternion_(quaternion.normalized()) {}
  /// The quaternion as it is: that of another rotation, whose bits another normalization might change.
  static SO3 from_unit(const Eigen::Quaterniond& quaternion) {
    SO3 rotation;
    rotation.quaternion_ = quaternion;
    return rotation;
  }
  /// The nearest rotation to `matrix`.
  static SO3 from_matrix(const Eigen::Matrix3d& matrix);

  static SO3 exp(const Eigen::Vector3d& tangent);
  /// The shortest rotation vector, of length 0 to pi.
  Eigen::Vector3d log() const;
  SO3 inverse() const { return SO3(quaternion_.conjugate()); }
  SO3 operator*(const SO3& other) const { return SO3(quaternion_ * other.quaternion_); }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return quaternion_ * point; }
  Eigen::Matrix3d adjoint() const { return matrix(); }
  Eigen::Matrix3d matrix() const { return quaternion_.toRotationMatrix(); }
  const Eigen::Quaterniond& quaternion() const { return quaternion_; }

  /// Derivative of adjoint() at the identity along `tangent`: the Lie bracket as a matrix.
  static Eigen::Matrix3d small_adjoint(const Eigen::Vector3d& tangent) { return hat(tangent); }
  /// exp(tangent + d) = exp(tangent) * exp(right_jacobian(tangent) * d) to first order in d.
  static Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& tangent) { return left_jacobian(-tangent); }
  /// exp(tangent + d) = exp(left_jacobian(tangent) * d) * exp(tangent) to first order in d.
  static Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& tangent);
  /// The inverses exist for rotations of less than 2 pi.
  static Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& tangent) {
    return left_jacobian_inverse(-tangent);
  }
  static Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& tangent);

 private:
  Eigen::Quaterniond quaternion_;
};

/// On the geodesic from a (fraction 0) to b (fraction 1).
SO3 interpolate(const SO3& a, const SO3& b, double fraction);

}  // namespace rastro
