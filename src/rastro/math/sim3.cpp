// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/sim3.h"

#include <Eigen/LU>
#include <cmath>

#include "rastro/base/error.h"

namespace rastro {
namespace {

/// Integral of u^n exp(rate * u) for u from 0 to 1, by the series whose terms all have one sign, so that nothing
/// cancels.
double growth_moment(int n, double rate) {
  if (rate >= 0.0) {
    double power = 1.0, sum = 0.0;
    for (int k = 0; k < 1000; ++k) {
      const double term = power / (n + k + 1);
      sum += term;
      if (term <= 1e-17 * sum) break;
      power *= rate / (k + 1);
    }
    return sum;
  }
  double term = 1.0 / (n + 1), sum = term;
  for (int k = 1; k < 1000 && term > 1e-17 * sum; ++k) {
    term *= -rate / (n + k + 1);
    sum += term;
  }
  return std::exp(rate) * sum;
}

/// Coefficients of I, hat(rotation) and hat(rotation)^2 in the integral over u from 0 to 1 of exp(log_scale * u) *
/// exp(hat(rotation) * u): the matrix that multiplies the translation of a tangent vector.
struct Coefficients {
  double identity, linear, square;
};

Coefficients series_coefficients(double angle, double log_scale) {
  Coefficients result{growth_moment(0, log_scale), 0.0, 0.0};
  double factor = 1.0;  // (-angle^2)^k / (2k + 1)!
  for (int k = 0; k < 7; ++k) {
    result.linear += factor * growth_moment(2 * k + 1, log_scale);
    result.square += factor / (2 * k + 2) * growth_moment(2 * k + 2, log_scale);
    factor *= -angle * angle / ((2 * k + 2) * (2 * k + 3));
  }
  return result;
}

Coefficients coefficients(double angle, double log_scale) {
  if (angle < 0.3) return series_coefficients(angle, log_scale);
  const double scale = std::exp(log_scale);
  const double sine = scale * std::sin(angle), cosine = scale * std::cos(angle);
  const double square = log_scale * log_scale + angle * angle;
  const double identity = std::abs(log_scale) < 1e-12 ? 1.0 : std::expm1(log_scale) / log_scale;
  const double along = ((cosine - 1.0) * log_scale + sine * angle) / square;
  const double across = (sine * log_scale + (1.0 - cosine) * angle) / square;
  return {identity, across / angle, (identity - along) / (angle * angle)};
}

Eigen::Matrix3d translation_matrix(const Eigen::Vector3d& rotation, double log_scale) {
  const auto [identity, linear, square] = coefficients(rotation.norm(), log_scale);
  const Eigen::Matrix3d skew = hat(rotation);
  return identity * Eigen::Matrix3d::Identity() + linear * skew + square * skew * skew;
}

}  // namespace

Sim3::Sim3(double scale, const SO3& rotation, const Eigen::Vector3d& translation)
    : scale_(scale), rotation_(rotation), translation_(translation) {
  RASTRO_CHECK(scale > 0.0, "the scale of a similarity must be positive");
}

Sim3 Sim3::exp(const Vector7d& tangent) {
  const Eigen::Vector3d rotation = tangent.segment<3>(3);
  return Sim3(std::exp(tangent[6]), SO3::exp(rotation), translation_matrix(rotation, tangent[6]) * tangent.head<3>());
}

Vector7d Sim3::log() const {
  const Eigen::Vector3d rotation = rotation_.log();
  const double log_scale = std::log(scale_);
  Vector7d tangent;
  tangent << translation_matrix(rotation, log_scale).partialPivLu().solve(translation_), rotation, log_scale;
  return tangent;
}

Sim3 Sim3::inverse() const {
  const SO3 rotation = rotation_.inverse();
  return Sim3(1.0 / scale_, rotation, -(rotation * translation_) / scale_);
}

Sim3 Sim3::operator*(const Sim3& other) const {
  return Sim3(scale_ * other.scale_, rotation_ * other.rotation_,
              scale_ * (rotation_ * other.translation_) + translation_);
}

Matrix7d Sim3::adjoint() const {
  const Eigen::Matrix3d rotation = rotation_.matrix();
  Matrix7d result = Matrix7d::Identity();
  result.topLeftCorner<3, 3>() = scale_ * rotation;
  result.block<3, 3>(0, 3) = hat(translation_) * rotation;
  result.block<3, 1>(0, 6) = -translation_;
  result.block<3, 3>(3, 3) = rotation;
  return result;
}

Matrix7d Sim3::small_adjoint(const Vector7d& tangent) {
  const Eigen::Matrix3d rotation = hat(tangent.segment<3>(3));
  Matrix7d result = Matrix7d::Zero();
  result.topLeftCorner<3, 3>() = rotation + tangent[6] * Eigen::Matrix3d::Identity();
  result.block<3, 3>(0, 3) = hat(tangent.head<3>());
  result.block<3, 1>(0, 6) = -tangent.head<3>();
  result.block<3, 3>(3, 3) = rotation;
  return result;
}

Eigen::Matrix4d Sim3::matrix() const {
  Eigen::Matrix4d result = Eigen::Matrix4d::Identity();
  result.topLeftCorner<3, 3>() = scale_ * rotation_.matrix();
  result.topRightCorner<3, 1>() = translation_;
  return result;
}

Sim3 interpolate(const Sim3& a, const Sim3& b, double fraction) {
  return a * Sim3::exp(fraction * (a.inverse() * b).log());
}

}  // namespace rastro
