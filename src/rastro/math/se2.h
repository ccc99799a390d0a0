// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/math/so2.h"

namespace rastro {

/// Rigid motion in the plane. `SE2 world_from_robot` maps points of the robot frame into the world frame.
/// Tangent vectors are (x, y, angle), meters and radians.
class SE2 {
 public:
  using Tangent = Eigen::Vector3d;
  using Point = Eigen::Vector2d;

  SE2() : translation_(Eigen::Vector2d::Zero()) {}
  SE2(const SO2& rotation, const Eigen::Vector2d& translation) : rotation_(rotation), translation_(translation) {}

  static SE2 exp(const Eigen::Vector3d& tangent);
  Eigen::Vector3d log() const;
  SE2 inverse() const;
  SE2 operator*(const SE2& other) const;
  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const { return rotation_ * point + translation_; }
  /// Maps right (local) tangent vectors to the left: exp(adjoint() * v) = *this * exp(v) * inverse().
  Eigen::Matrix3d adjoint() const;
  Eigen::Matrix3d matrix() const;
  /// Derivative of adjoint() at the identity along `tangent`: the Lie bracket as a matrix.
  static Eigen::Matrix3d small_adjoint(const Eigen::Vector3d& tangent);

  const SO2& rotation() const { return rotation_; }
  const Eigen::Vector2d& translation() const { return translation_; }

 private:
  SO2 rotation_;
  Eigen::Vector2d translation_;
};

/// On the geodesic from a (fraction 0) to b (fraction 1).
SE2 interpolate(const SE2& a, const SE2& b, double fraction);

}  // namespace rastro
