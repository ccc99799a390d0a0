// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/se2.h"

namespace rastro {
namespace {

/// Integral of the rotation from 0 to `angle`: [sine, -cosine; cosine, sine] of the result.
struct RotationIntegral {
  double sine;    ///< sin(angle) / angle
  double cosine;  ///< (1 - cos(angle)) / angle
};

RotationIntegral rotation_integral(double angle) {
  if (std::abs(angle) < 1e-4) return {1.0 - angle * angle / 6.0, 0.5 * angle};
  const double half_sine = std::sin(0.5 * angle);
  return {std::sin(angle) / angle, 2.0 * half_sine * half_sine / angle};
}

}  // namespace

SE2 SE2::exp(const Eigen::Vector3d& tangent) {
  const auto [sine, cosine] = rotation_integral(tangent.z());
  return SE2(SO2::from_angle(tangent.z()),
             {sine * tangent.x() - cosine * tangent.y(), cosine * tangent.x() + sine * tangent.y()});
}

Eigen::Vector3d SE2::log() const {
  const double angle = rotation_.angle();
  const auto [sine, cosine] = rotation_integral(angle);
  const double square = sine * sine + cosine * cosine;
  return {(sine * translation_.x() + cosine * translation_.y()) / square,
          (sine * translation_.y() - cosine * translation_.x()) / square, angle};
}

SE2 SE2::inverse() const {
  const SO2 rotation = rotation_.inverse();
  return SE2(rotation, -(rotation * translation_));
}

SE2 SE2::operator*(const SE2& other) const {
  return SE2(rotation_ * other.rotation_, rotation_ * other.translation_ + translation_);
}

Eigen::Matrix3d SE2::adjoint() const {
  Eigen::Matrix3d result = matrix();
  result.topRightCorner<2, 1>() << translation_.y(), -translation_.x();
  return result;
}

Eigen::Matrix3d SE2::small_adjoint(const Eigen::Vector3d& tangent) {
  Eigen::Matrix3d result;
  result << 0.0, -tangent.z(), tangent.y(), tangent.z(), 0.0, -tangent.x(), 0.0, 0.0, 0.0;
  return result;
}

Eigen::Matrix3d SE2::matrix() const {
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() = rotation_.matrix();
  result.topRightCorner<2, 1>() = translation_;
  return result;
}

SE2 interpolate(const SE2& a, const SE2& b, double fraction) {
  return a * SE2::exp(fraction * (a.inverse() * b).log());
}

}  // namespace rastro
