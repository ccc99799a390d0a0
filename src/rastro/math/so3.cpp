// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/so3.h"

#include <Eigen/SVD>
#include <cmath>

namespace rastro {
namespace {

// Below this squared angle the closed forms lose digits to cancellation and the series are exact to the last bit.
constexpr double series_below = 0.04;

/// sin(x) / x.
double sinc(double x) { return std::abs(x) < 1e-4 ? 1.0 - x * x / 6.0 : std::sin(x) / x; }

/// (1 - cos(angle)) / angle^2, through half the angle so that nothing cancels.
double one_minus_cosine_over_square(double angle) {
  const double half = sinc(0.5 * angle);
  return 0.5 * half * half;
}

/// (angle - sin(angle)) / angle^3.
double angle_minus_sine_over_cube(double angle) {
  const double square = angle * angle;
  if (square > series_below) return (angle - std::sin(angle)) / (angle * square);
  return (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0 * (1.0 - square / 110.0)))) / 6.0;
}

/// (1 - angle/2 * cot(angle/2)) / angle^2: finite up to 2 pi.
double inverse_jacobian_coefficient(double angle) {
  const double square = angle * angle;
  if (square > series_below) return (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / square;
  return 1.0 / 12.0 +
         square * (1.0 / 720.0 + square * (1.0 / 30240.0 + square * (1.0 / 1209600.0 + square * (1.0 / 47900160.0))));
}

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& vector) {
  Eigen::Matrix3d result;
  result << 0.0, -vector.z(), vector.y(), vector.z(), 0.0, -vector.x(), -vector.y(), vector.x(), 0.0;
  return result;
}

SO3 SO3::from_matrix(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d signs(1.0, 1.0, handedness);
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return SO3(Eigen::Quaterniond(rotation));
}

SO3 SO3::exp(const Eigen::Vector3d& tangent) {
  const double half_angle = 0.5 * tangent.norm();
  const Eigen::Vector3d imaginary = 0.5 * sinc(half_angle) * tangent;
  return SO3(Eigen::Quaterniond(std::cos(half_angle), imaginary.x(), imaginary.y(), imaginary.z()));
}

Eigen::Vector3d SO3::log() const {
  // q and -q are one rotation: the one with w >= 0 gives the shorter vector.
  const double sign = quaternion_.w() < 0.0 ? -1.0 : 1.0;
  const double w = sign * quaternion_.w();
  const Eigen::Vector3d imaginary = sign * quaternion_.vec();
  const double sine = imaginary.norm();
  if (sine < 1e-8) return imaginary * (2.0 / w);  // atan(s / w) = s / w to the last bit.
  return imaginary * (2.0 * std::atan2(sine, w) / sine);
}

Eigen::Matrix3d SO3::left_jacobian(const Eigen::Vector3d& tangent) {
  const double angle = tangent.norm();
  const Eigen::Matrix3d skew = hat(tangent);
  return Eigen::Matrix3d::Identity() + one_minus_cosine_over_square(angle) * skew +
         angle_minus_sine_over_cube(angle) * skew * skew;
}

Eigen::Matrix3d SO3::left_jacobian_inverse(const Eigen::Vector3d& tangent) {
  const Eigen::Matrix3d skew = hat(tangent);
  return Eigen::Matrix3d::Identity() - 0.5 * skew + inverse_jacobian_coefficient(tangent.norm()) * skew * skew;
}

SO3 interpolate(const SO3& a, const SO3& b, double fraction) {
  return a * SO3::exp(fraction * (a.inverse() * b).log());
}

}  // namespace rastro
