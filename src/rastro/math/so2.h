// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <complex>

namespace rastro {

/// Rotation in the plane, kept as a unit complex number. The tangent vector is the angle in radians, counter-clockwise.
class SO2 {
 public:
  using Tangent = Eigen::Matrix<double, 1, 1>;
  using Point = Eigen::Vector2d;

  SO2() : unit_(1.0, 0.0) {}
  static SO2 from_angle(double radians) { return SO2(std::complex<double>(std::cos(radians), std::sin(radians))); }
  static SO2 exp(const Tangent& tangent) { return from_angle(tangent[0]); }
  Tangent log() const { return Tangent(angle()); }
  /// In -pi to pi.
  double angle() const { return std::atan2(unit_.imag(), unit_.real()); }
  SO2 inverse() const { return SO2(std::conj(unit_)); }
  SO2 operator*(const SO2& other) const { return SO2(unit_ * other.unit_); }
  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const {
    return {unit_.real() * point.x() - unit_.imag() * point.y(), unit_.imag() * point.x() + unit_.real() * point.y()};
  }
  Eigen::Matrix<double, 1, 1> adjoint() const { return Eigen::Matrix<double, 1, 1>(1.0); }
  static Eigen::Matrix<double, 1, 1> small_adjoint(const Tangent&) { return Eigen::Matrix<double, 1, 1>(0.0); }
  Eigen::Matrix2d matrix() const {
    return (Eigen::Matrix2d() << unit_.real(), -unit_.imag(), unit_.imag(), unit_.real()).finished();
  }

 private:
  explicit SO2(const std::complex<double>& unit) : unit_(unit / std::abs(unit)) {}
  std::complex<double> unit_;
};

/// Along the shorter arc from a (fraction 0) to b (fraction 1).
inline SO2 interpolate(const SO2& a, const SO2& b, double fraction) {
  return a * SO2::from_angle(fraction * (a.inverse() * b).angle());
}

}  // namespace rastro
