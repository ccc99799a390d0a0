// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "rastro/math/so3.h"

namespace rastro {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Rigid motion. `SE3 world_from_camera` maps points of the camera frame into the world frame:
/// p_in_world = world_from_camera * p_in_camera. Tangent vectors are (translation, rotation).
/// Sola et al. 2018, "A micro Lie theory for state estimation in robotics".
class SE3 {
 public:
  using Tangent = Vector6d;
  using Point = Eigen::Vector3d;

  SE3() : translation_(Eigen::Vector3d::Zero()) {}
  SE3(const SO3& rotation, const Eigen::Vector3d& translation) : rotation_(rotation), translation_(translation) {}

  static SE3 exp(const Vector6d& tangent);
  Vector6d log() const;
  SE3 inverse() const;
  SE3 operator*(const SE3& other) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return rotation_ * point + translation_; }
  /// Maps right (local) tangent vectors to the left: exp(adjoint() * v) = *this * exp(v) * inverse().
  Matrix6d adjoint() const;
  Eigen::Matrix4d matrix() const;
  /// From the upper 3x4; the rotation part is projected to the nearest rotation.
  static SE3 from_matrix(const Eigen::Matrix4d& matrix);
  /// Derivative of adjoint() at the identity along `tangent`: the Lie bracket as a matrix.
  static Matrix6d small_adjoint(const Vector6d& tangent);

  const SO3& rotation() const { return rotation_; }
  const Eigen::Vector3d& translation() const { return translation_; }

 private:
  SO3 rotation_;
  Eigen::Vector3d translation_;
};

/// On the geodesic from a (fraction 0) to b (fraction 1).
SE3 interpolate(const SE3& a, const SE3& b, double fraction);

}  // namespace rastro
