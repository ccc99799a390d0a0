// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "rastro/math/se3.h"

namespace rastro {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

/// Similarity: p_in_target = scale * rotation * p_in_source + translation. Tangent vectors are (translation, rotation,
/// log of the scale). Closed forms after Eade, "Lie groups for 2D and 3D transformations", 2013.
class Sim3 {
 public:
  using Tangent = Vector7d;
  using Point = Eigen::Vector3d;

  Sim3() : translation_(Eigen::Vector3d::Zero()) {}
  /// `scale` must be positive.
  Sim3(double scale, const SO3& rotation, const Eigen::Vector3d& translation);
  explicit Sim3(const SE3& rigid) : rotation_(rigid.rotation()), translation_(rigid.translation()) {}

  static Sim3 exp(const Vector7d& tangent);
  Vector7d log() const;
  Sim3 inverse() const;
  Sim3 operator*(const Sim3& other) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return scale_ * (rotation_ * point) + translation_; }
  /// Maps right (local) tangent vectors to the left: exp(adjoint() * v) = *this * exp(v) * inverse().
  Matrix7d adjoint() const;
  Eigen::Matrix4d matrix() const;
  /// Derivative of adjoint() at the identity along `tangent`: the Lie bracket as a matrix.
  static Matrix7d small_adjoint(const Vector7d& tangent);

  double scale() const { return scale_; }
  const SO3& rotation() const { return rotation_; }
  const Eigen::Vector3d& translation() const { return translation_; }

 private:
  double scale_ = 1.0;
  SO3 rotation_;
  Eigen::Vector3d translation_;
};

/// On the geodesic from a (fraction 0) to b (fraction 1).
Sim3 interpolate(const Sim3& a, const Sim3& b, double fraction);

}  // namespace rastro
